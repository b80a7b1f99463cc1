// soar's geomorph: one surface, between its ends, that moves only as fast as the eye.
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "arete/lod/engine.h"

#include "lod/built_terrain.h"
#include "lod/plain_refinement.h"

namespace arete::lod::bintree {
namespace {

// Morphing begins at two thirds of the tolerance.
constexpr double kSharper = 1.5;

class SoarMorph : public testing::Test {
 protected:
  static View view_at(glm::dvec3 eye) {
    return make_view({.eye = eye, .yaw = 0.7, .pitch = -0.4, .near_m = 1}, 320, 240);
  }
  void draw(Engine& engine, glm::dvec3 eye) {
    engine.refine(view_at(eye), options_, list_);
    mesh::flatten(list_, engine, surface_);
  }

  /// Heights of the drawn surface at all posts of the domain, row by row.
  std::vector<double> drawn_heights() const {
    const int posts = records_.domain().side() + 1;
    std::vector<double> out(static_cast<std::size_t>(posts * posts));
    for (std::size_t i = 0; i < surface_.indices.size(); i += 3) {
      const auto& a = surface_.vertices[surface_.indices[i]];
      const auto& b = surface_.vertices[surface_.indices[i + 1]];
      const auto& c = surface_.vertices[surface_.indices[i + 2]];
      const auto side = [](Post p, Post q, int col, int row) {
        return static_cast<double>((q.col - p.col) * (row - p.row) -
                                   (q.row - p.row) * (col - p.col));
      };
      const double area = side(a.post, b.post, c.post.col, c.post.row);
      const auto [c0, c1] = std::minmax({a.post.col, b.post.col, c.post.col});
      const auto [r0, r1] = std::minmax({a.post.row, b.post.row, c.post.row});
      for (int row = r0; row <= r1; ++row) {
        for (int col = c0; col <= c1; ++col) {
          const double u = side(b.post, c.post, col, row) / area;
          const double v = side(c.post, a.post, col, row) / area;
          if (u < 0 || v < 0 || u + v > 1) continue;
          out[static_cast<std::size_t>(row * posts + col)] = u * a.z + v * b.z + (1 - u - v) * c.z;
        }
      }
    }
    return out;
  }

  /// The largest step of any post between two frames, over flights with steps of the eye so long.
  double largest_jump(Engine& engine, double step_m) {
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> unit(-1, 1);
    double jump = 0;
    for (int flight = 0; flight < 8; ++flight) {
      glm::dvec3 eye(1500 + 1400 * unit(random), -1500 + 1400 * unit(random), 1300);
      const glm::dvec3 step =
          step_m * glm::normalize(glm::dvec3(unit(random), unit(random), unit(random)));
      draw(engine, eye);
      std::vector<double> before = drawn_heights();
      for (int frame = 0; frame < 40; ++frame) {
        draw(engine, eye += step);
        const std::vector<double> now = drawn_heights();
        for (std::size_t i = 0; i < now.size(); ++i)
          jump = std::max(jump, std::abs(now[i] - before[i]));
        before = now;
      }
    }
    return jump;
  }

  /// Vertices that are not between their own height and the middle of the edge that they halve, as
  /// drawn. `full`, `flat`: how many are at either end, but for a hundredth of the way.
  struct Ends {
    int outside = 0, full = 0, flat = 0, between = 0;
    int sunk = 0;  ///< below their height though the whole tolerance selects them
  };
  Ends ends_of(glm::dvec3 eye) {
    const View view = view_at(eye);
    const ScreenError error(view, options_.tolerance_px, options_.scale);
    const Criterion inner(view, error, kSharper);
    const Criterion outer(view, error);
    const PlainRefinement plain(records_, ground_, inner, options_.cull);
    std::vector<float> z(
        static_cast<std::size_t>((records_.domain().side() + 1) * (records_.domain().side() + 1)));
    const auto at = [&](Post p) -> float& {
      return z[static_cast<std::size_t>(p.row * (records_.domain().side() + 1) + p.col)];
    };
    for (const mesh::SurfaceVertex& v : surface_.vertices) at(v.post) = v.z;
    Ends ends;
    for (const auto& h : plain.halvings) {
      const double own = ground_.z_of(records_[h.vertex]);
      const bool whole = outer.selected(ground_.ball(h.vertex, records_[h.vertex]));
      if (whole && at(h.vertex) != static_cast<float>(own)) ++ends.sunk;
      const double flat = (static_cast<double>(at(h.left)) + at(h.right)) / 2;
      const double share = (at(h.vertex) - flat) / (own - flat);
      if (std::abs(own - flat) < 0.01) continue;  // nothing to be seen of it
      if (share < -0.001 || share > 1.001) ++ends.outside;
      if (share > 0.99) ++ends.full;
      if (share < 0.01) ++ends.flat;
      if (share > 0.01 && share < 0.99) ++ends.between;
    }
    EXPECT_EQ(sorted_triangles(surface_), plain.leaves);
    return ends;
  }

  const RecordedTerrain recorded_{rough_dem(65, 65, 11, 0)};
  Ground ground_{recorded_.terrain(), {}};
  AllRecords records_{recorded_.terrain(), Delta::Exact};
  RefineOptions options_{.tolerance_px = 4, .cull = false};
  std::unique_ptr<Engine> soar_ = find_engine("soar").open(recorded_.terrain(), {});
  std::unique_ptr<Engine> morphing_ =
      find_engine("soar").open(recorded_.terrain(), {{"morph", "true"}});
  DrawList list_;
  mesh::Surface surface_;
};

TEST_F(SoarMorph, ConformsAndVerticesLieBetweenTheirEnds) {
  Ends all;
  for (int i = 0; i < 60; ++i) {
    const glm::dvec3 eye(60.0 * i - 500, -40.0 * i, 900 + 40 * i);
    draw(*morphing_, eye);
    const auto report = mesh::check_surface(surface_, recorded_.dem(), nullptr);
    ASSERT_EQ(report.cracks() + report.t_junctions, 0U) << i;
    const Ends ends = ends_of(eye);
    EXPECT_EQ(ends.outside, 0) << i;
    EXPECT_EQ(ends.sunk, 0) << i;
    all.full += ends.full;
    all.flat += ends.flat;
    all.between += ends.between;
  }
  EXPECT_GT(all.full, 1000);  // they do go from one end to the other
  EXPECT_GT(all.flat, 10);
  EXPECT_GT(all.between, 1000);
}

TEST_F(SoarMorph, ChecksCatchAVertexOutOfPlace) {
  const glm::dvec3 eye(500, -700, 1200);
  draw(*morphing_, eye);
  const mesh::Surface right = surface_;
  constexpr std::size_t kEvery = 7;
  int outside = 0;
  std::uint64_t mismatches = 0;
  for (std::size_t i = 0; i < right.vertices.size(); i += kEvery) {
    surface_ = right;
    surface_.vertices[i].z += 300;
    outside += ends_of(eye).outside > 0 ? 1 : 0;
    mismatches += mesh::check_surface(surface_, recorded_.dem(), nullptr).height_mismatches;
  }
  EXPECT_GT(outside, static_cast<int>(right.vertices.size() / kEvery) / 2);
  EXPECT_GT(mismatches, 0U);  // of vertices that the strip holds twice
}

// A vertex moves by |z - flat| |dshare|, and |dshare| <= 2 |dP| / (none - full) with none - full =
// nu delta / 2; what its edge's ends move comes on top, once for every depth.
TEST_F(SoarMorph, HeightsFollowTheEye) {
  const View view = view_at({});
  const double nu = Criterion(view, {view, options_.tolerance_px, options_.scale}).nu();
  const double rate = 2 * 4 / nu * records_.domain().depths();
  const double fast = largest_jump(*morphing_, 8);
  const double slow = largest_jump(*morphing_, 0.125);
  EXPECT_LT(fast, 8 * rate);
  EXPECT_LT(slow, 0.125 * rate);
  EXPECT_LT(slow, fast / 32);
  // The control: without geomorph a vertex comes at once, however slow the eye.
  EXPECT_GT(largest_jump(*soar_, 0.125), rate);
}

}  // namespace
}  // namespace arete::lod::bintree
