// Every engine x terrain x view x residency (CONVENTIONS I1 to I7). A new row of engines.cpp is
// tested by itself.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <thread>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "arete/core/error.h"
#include "arete/lod/engine.h"
#include "arete/lod/least_fitting.h"
#include "arete/mesh/surface.h"

#include "lod/built_terrain.h"
#include "lod/variants.h"

namespace arete::lod {
namespace {

struct Case {
  std::string name;
  std::function<Heightfield()> dem;
};

Heightfield flat_dem() {
  Georef georef;
  georef.world_from_post.m = {10, 0, 0, 0, -10, 0};
  return {65, 65, georef};
}

Heightfield rotated_dem() {
  Heightfield dem = rough_dem(150, 131, 5, 0);
  Georef georef;
  georef.world_from_post.m = {20, 15, 0, 15, -20, 0};
  Heightfield out(dem.cols(), dem.rows(), georef);
  for (int r = 0; r < dem.rows(); ++r) {
    for (int c = 0; c < dem.cols(); ++c) out[{c, r}] = dem[{c, r}];
  }
  return out;
}

// A few posts of land off every coarse grid, and a speck: most coarse tiles hold no valid post.
Heightfield island_dem() {
  Heightfield dem = rough_dem(513, 513, 8, 0);
  const auto land = [](int col, int row) {
    return (col > 200 && col < 204 && row > 100 && row < 104) ||
           (col > 401 && col < 440 && row > 301 && row < 330);
  };
  for (int r = 0; r < dem.rows(); ++r) {
    for (int c = 0; c < dem.cols(); ++c) {
      if (!land(c, r)) dem[{c, r}] = std::numeric_limits<float>::quiet_NaN();
    }
  }
  return dem;
}

std::vector<Case> cases() {
  return {{"rough", [] { return rough_dem(257, 193, 1, 0); }},
          {"holes", [] { return rough_dem(200, 131, 2, 0.2); }},
          {"strip", [] { return rough_dem(400, 3, 3, 0); }},
          {"tiny", [] { return rough_dem(2, 2, 4, 0); }},
          {"flat", flat_dem},
          {"islands", island_dem},
          {"rotated", rotated_dem}};
}

std::vector<View> views(const Heightfield& dem, int count) {
  std::mt19937_64 random(42);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<View> out;
  for (int k = 0; k < count; ++k) {
    const glm::dvec2 plan = dem.georef().world_from_post.apply(
        (1.2 * unit(random) - 0.1) * dem.cols(), (1.2 * unit(random) - 0.1) * dem.rows());
    const double z = k % 3 == 0 ? 400 + 100 * unit(random) : 1000 + 6000 * unit(random);
    out.push_back(make_view(
        {.eye = {plan, z}, .yaw = 6.3 * unit(random), .pitch = -1.4 * unit(random), .near_m = 1},
        320, 240));
  }
  return out;
}

// Largest |drawn - dem| of one batch over the posts of drawable cells.
double measured_error(const DrawList& list, const DrawBatch& batch, const BlockSource& blocks,
                      const Heightfield& dem) {
  DrawList one = list;
  one.batches = {batch};
  mesh::Surface surface;
  mesh::flatten(one, blocks, surface);
  const auto counts = [&](int col, int row) {
    if (col >= dem.cols() || row >= dem.rows()) return false;
    for (const auto& [dc, dr] : {std::pair{0, 0}, {-1, 0}, {0, -1}, {-1, -1}}) {
      const Post cell{col + dc, row + dr};
      if (cell.col < 0 || cell.row < 0 || cell.col + 1 >= dem.cols() || cell.row + 1 >= dem.rows())
        continue;
      if (dem.drawable(cell)) return true;
    }
    return false;
  };
  double worst = 0;
  for (std::size_t t = 0; t < surface.indices.size(); t += 3) {
    const auto& a = surface.vertices[surface.indices[t]];
    const auto& b = surface.vertices[surface.indices[t + 1]];
    const auto& c = surface.vertices[surface.indices[t + 2]];
    const auto cross = [](Post p, Post q, int col, int row) {
      return static_cast<double>(q.col - p.col) * (row - p.row) -
             static_cast<double>(q.row - p.row) * (col - p.col);
    };
    const double area = cross(a.post, b.post, c.post.col, c.post.row);
    const auto [c0, c1] = std::minmax({a.post.col, b.post.col, c.post.col});
    const auto [r0, r1] = std::minmax({a.post.row, b.post.row, c.post.row});
    for (int row = r0; row <= r1; ++row) {
      for (int col = c0; col <= c1; ++col) {
        const double u = cross(b.post, c.post, col, row) / area;
        const double v = cross(c.post, a.post, col, row) / area;
        if (u < 0 || v < 0 || u + v > 1 || !counts(col, row)) continue;
        const double z = u * a.z + v * b.z + (1 - u - v) * c.z;
        worst = std::max(worst, std::abs(z - dem[{col, row}]));
      }
    }
  }
  return worst;
}

void expect_conforming(const mesh::SurfaceReport& report) {
  EXPECT_EQ(report.flipped, 0U);
  EXPECT_EQ(report.overlaps, 0U);
  EXPECT_EQ(report.t_junctions, 0U);
  EXPECT_EQ(report.height_mismatches, 0U);
  EXPECT_EQ(report.uncovered_cells, 0U);
}

// Heights that cannot be read: after `arm`, every read of their segment whose offset hashes below
// the share fails.
struct Faults {
  std::atomic<bool> armed{false};
  double share = 0;
};

class FaultyFile final : public store::File {
 public:
  FaultyFile(std::unique_ptr<store::File> file, const Faults& faults)
      : file_(std::move(file)), faults_(faults) {}
  std::uint64_t size() const override { return file_->size(); }
  void read_at(std::uint64_t offset, std::span<std::byte> out) const override {
    std::mt19937_64 hash(offset);
    if (faults_.armed && static_cast<double>(hash() % 1000) < 1000 * faults_.share) {
      throw Error(ErrorCode::Io, "segment: cannot be read: planted by the test");
    }
    file_->read_at(offset, out);
  }

 private:
  std::unique_ptr<store::File> file_;
  const Faults& faults_;
};

class Conformance : public testing::TestWithParam<Variant> {};

TEST_P(Conformance, SurfaceIsOneTriangulationAndErrorsAreBounds) {
  const Variant& tested = GetParam();
  for (const Case& c : cases()) {
    for (const char* patch : {"9", "17", "65"}) {
      const BuiltTerrain terrain(c.dem(), {{"patch", patch}});
      const auto opened = terrain.open();
      const auto engine = tested.open(*opened, patch);
      DrawList list;
      mesh::Surface surface;
      for (const View& view : views(terrain.dem(), 6)) {
        SCOPED_TRACE(
            fmt::format("{} {} eye {} {} {}", c.name, patch, view.eye.x, view.eye.y, view.eye.z));
        for (const bool cull : {false, true}) {
          const RefineOptions options{.tolerance_px = 2, .cull = cull};
          engine->refine(view, options, list);
          mesh::flatten(list, *engine, surface);
          const auto report = mesh::check_surface(surface, terrain.dem(), cull ? &view : nullptr);
          EXPECT_EQ(report.triangles, list.stats.triangles);
          if (engine->claims(options).conforming) expect_conforming(report);
          for (const DrawBatch& batch : list.batches) {
            ASSERT_LE(measured_error(list, batch, *engine, terrain.dem()),
                      batch.error * (1 + 1e-6) + 1e-3);
          }
          EXPECT_EQ(list.stats.late_blocks, 0U);
          if (std::isfinite(engine->claims(options).error_px)) {
            EXPECT_LE(list.stats.achieved_error_px, options.tolerance_px * (1 + 1e-4));
          }
        }
      }
    }
  }
}

TEST_P(Conformance, SameViewSameListWhateverCameBefore) {
  const Variant& tested = GetParam();
  const BuiltTerrain terrain(rough_dem(200, 131, 2, 0.2), {{"patch", "17"}});
  const auto opened = terrain.open();
  const auto engine = tested.open(*opened, "17");
  auto all = views(terrain.dem(), 12);
  std::vector<std::vector<DrawBatch>> first;
  DrawList list;
  for (const View& view : all) {
    engine->refine(view, {}, list);
    first.push_back(list.batches);
  }
  for (std::size_t k = all.size(); k-- > 0;) {
    engine->refine(all[k], {}, list);
    ASSERT_EQ(list.batches.size(), first[k].size());
    for (std::size_t b = 0; b < first[k].size(); ++b) {
      EXPECT_EQ(list.batches[b].vertices, first[k][b].vertices);
      EXPECT_EQ(list.batches[b].indices, first[k][b].indices);
      EXPECT_EQ(list.batches[b].factor, first[k][b].factor);
    }
  }
}

TEST_P(Conformance, AnySubsetOfTilesMissingStillConforms) {
  const Variant& tested = GetParam();
  for (const double share : {0.3, 0.8, 1.0}) {
    const BuiltTerrain terrain(rough_dem(513, 400, 6, 0.05), {{"patch", "17"}});
    Faults faults{.share = share};
    store::OpenOptions open;
    open.open = [&](const std::filesystem::path& path) -> std::unique_ptr<store::File> {
      auto file = store::open_file(path);
      if (path.filename() != "heights.seg" && path.filename() != "bintree.seg") return file;
      return std::make_unique<FaultyFile>(std::move(file), faults);
    };
    const auto opened = terrain.open(open);
    const auto engine = tested.open(*opened, "17");
    faults.armed = true;
    DrawList list;
    mesh::Surface surface;
    std::uint64_t late = 0;
    for (const View& view : views(terrain.dem(), 6)) {
      SCOPED_TRACE(fmt::format("share {} eye {} {}", share, view.eye.x, view.eye.y));
      const RefineOptions options{.tolerance_px = 1, .cull = false};
      engine->refine(view, options, list);
      late += list.stats.late_blocks;
      mesh::flatten(list, *engine, surface);
      if (engine->claims(options).conforming) {
        expect_conforming(mesh::check_surface(surface, terrain.dem(), nullptr));
      }
      for (const DrawBatch& batch : list.batches) {
        ASSERT_LE(measured_error(list, batch, *engine, terrain.dem()),
                  batch.error * (1 + 1e-6) + 1e-3);
      }
    }
    EXPECT_GT(late, 0U);  // the control: tiles did go missing
  }
}

TEST_P(Conformance, DeferringDrawsCoarserThenCatchesUp) {
  const Variant& tested = GetParam();
  const BuiltTerrain terrain(rough_dem(513, 400, 6, 0), {{"patch", "17"}});
  const auto opened = terrain.open();
  const auto engine = tested.open(*opened, "17");
  const View view = views(terrain.dem(), 1)[0];
  DrawList list;
  std::uint64_t late = 0;
  for (int k = 0; k < 2000; ++k) {
    engine->refine(view, {.on_missing = OnMissing::Defer}, list);
    if (k == 0) {
      EXPECT_GT(list.stats.late_blocks, 0U);
    }
    late = list.stats.late_blocks;
    if (late == 0) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_EQ(late, 0U);
}

TEST_P(Conformance, LargerToleranceIsNotMoreTriangles) {
  const Variant& tested = GetParam();
  const BuiltTerrain terrain(rough_dem(257, 193, 1, 0), {{"patch", "17"}});
  const auto opened = terrain.open();
  const auto engine = tested.open(*opened, "17");
  DrawList list;
  for (const View& view : views(terrain.dem(), 5)) {
    std::uint64_t last = std::numeric_limits<std::uint64_t>::max();
    for (const double tolerance : {1e-9, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 32.0}) {
      engine->refine(view, {.tolerance_px = tolerance, .cull = false}, list);
      EXPECT_LE(list.stats.triangles, last);
      if (last == std::numeric_limits<std::uint64_t>::max()) {
        // Tolerance -> 0: everything, or all but what is flat.
        const bool everything = list.stats.triangles == list.stats.full_triangles;
        for (const DrawBatch& batch : list.batches) EXPECT_TRUE(everything || batch.error < 1e-3);
      }
      last = list.stats.triangles;
    }
  }
}

// A cap between what the coarsest surface needs and `need`, often near the former.
std::uint64_t random_cap(std::uint64_t least, std::uint64_t need, std::mt19937_64& random) {
  const double share = std::pow(std::uniform_real_distribution<double>(0, 1)(random), 4);
  return least + static_cast<std::uint64_t>(share * static_cast<double>(need - least));
}

TEST_P(Conformance, BudgetsHoldAndTheCoarserSurfaceKeepsItsBounds) {
  const Variant& tested = GetParam();
  std::mt19937_64 random(5);
  int capped = 0;
  for (const Case& c : cases()) {
    const BuiltTerrain terrain(c.dem(), {{"patch", "17"}});
    const auto opened = terrain.open();
    const auto engine = tested.open(*opened, "17");
    const Budget least = engine->footprint().least;
    DrawList list;
    mesh::Surface surface;
    for (const View& view : views(terrain.dem(), 24)) {
      RefineOptions options{.cull = random() % 2 == 0};
      engine->refine(view, options, list);
      const RefineStats free = list.stats;
      options.budget = {
          random_cap(least.triangles, std::max(free.triangles, least.triangles), random),
          random_cap(least.vertex_bytes, std::max(free.resident_bytes, least.vertex_bytes),
                     random)};
      SCOPED_TRACE(fmt::format("{} eye {} {} {}: {} triangles, {} bytes", c.name, view.eye.x,
                               view.eye.y, view.eye.z, options.budget.triangles,
                               options.budget.vertex_bytes));
      engine->refine(view, options, list);
      EXPECT_LE(list.stats.triangles, options.budget.triangles);
      EXPECT_LE(list.stats.resident_bytes, options.budget.vertex_bytes);
      EXPECT_GE(list.stats.tolerance_px, free.tolerance_px);
      if (std::isfinite(engine->claims(options).error_px)) {
        EXPECT_LE(list.stats.achieved_error_px, list.stats.tolerance_px * (1 + 1e-4));
      }
      capped += list.stats.tolerance_px > free.tolerance_px ? 1 : 0;
      mesh::flatten(list, *engine, surface);
      const auto report =
          mesh::check_surface(surface, terrain.dem(), options.cull ? &view : nullptr);
      EXPECT_EQ(report.triangles, list.stats.triangles);
      if (engine->claims(options).conforming) expect_conforming(report);
      for (const DrawBatch& batch : list.batches) {
        ASSERT_LE(measured_error(list, batch, *engine, terrain.dem()),
                  batch.error * (1 + 1e-6) + 1e-3);
      }
      engine->refine(view, {}, list);  // the cap is of that frame alone
      EXPECT_EQ(list.stats.tolerance_px, free.tolerance_px);
    }
  }
  EXPECT_GT(capped, 40);  // the control: caps did bind
}

TEST_P(Conformance, AnySmallerBudgetIsKeptByALargerTolerance) {
  const Variant& tested = GetParam();
  const BuiltTerrain terrain(rough_dem(257, 193, 1, 0), {{"patch", "17"}});
  const auto opened = terrain.open();
  const auto engine = tested.open(*opened, "17");
  const Footprint footprint = engine->footprint();
  DrawList list;
  for (const View& view : views(terrain.dem(), 5)) {
    double tolerance = 0;
    std::uint64_t before = 0;
    for (double share = 1; share > 1e-3; share /= 1.7) {
      RefineOptions options{.cull = false};
      options.budget.triangles =
          std::max(footprint.least.triangles, static_cast<std::uint64_t>(50'000 * share));
      engine->refine(view, options, list);
      EXPECT_GE(list.stats.tolerance_px, tolerance * (1 - 2 * kFitStep));
      tolerance = list.stats.tolerance_px;
      if (before > 0) {
        EXPECT_LE(list.stats.triangles, before);
      }
      before = list.stats.triangles;
    }
    EXPECT_GT(tolerance, 1);
  }
  EXPECT_THROW(require_room(footprint, {.triangles = footprint.least.triangles - 1}, "t"), Error);
  EXPECT_THROW(require_room(footprint, {.vertex_bytes = footprint.least.vertex_bytes - 1}, "t"),
               Error);
  require_room(footprint, footprint.least, "t");
}

INSTANTIATE_TEST_SUITE_P(All, Conformance, testing::ValuesIn(variants()),
                         [](const auto& tested) { return tested.param.name; });

}  // namespace
}  // namespace arete::lod
