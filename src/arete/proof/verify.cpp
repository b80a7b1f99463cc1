#include "arete/proof/verify.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "arete/core/error.h"
#include "arete/mesh/surface.h"
#include "arete/proof/dump.h"
#include "arete/proof/pop.h"
#include "arete/proof/reference.h"
#include "arete/proof/residual.h"

namespace arete::proof {
namespace {

constexpr double kPairSeconds = 1.0 / 60;
constexpr int kWholeEvery = 10;  // every so many frames the whole domain is checked, too

// Of the vertex blocks that the list names, of indices made for the view, and of its own arrays.
std::uint64_t named_bytes(const DrawList& list, const BlockSource& blocks) {
  std::vector<BlockKey> keys;
  for (const DrawBatch& batch : list.batches) {
    if (batch.vertices != kOwnBlock) keys.push_back(batch.vertices);
  }
  std::ranges::sort(keys);
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
  std::uint64_t bytes =
      list.vertices.size() * sizeof(Vertex) + list.indices.size() * sizeof(std::uint32_t);
  for (const BlockKey key : keys) bytes += blocks.vertices(key).size_bytes();
  for (const Upload& u : list.uploads) {
    if (u.kind == BlockKind::Indices) bytes += u.count * sizeof(std::uint32_t);
  }
  return bytes;
}

class Flight {
 public:
  Flight(lod::Engine& engine, const Heightfield& dem, const VerifyOptions& options)
      : engine_(engine), dem_(dem), options_(options), reference_(dem, options.threads) {
    if (!draw_depth_) {
      gl_ = std::make_unique<GlPicture>(dem, options.gpu_memory);
      draw_depth_ = [this](const View& v, const DrawList& list, const BlockSource& blocks) {
        return gl_->depth(v, list, blocks);
      };
      fit_to_gpu();
    }
    report_.tolerance_px = refine_.tolerance_px;
    whole_ = refine_;
    whole_.cull = false;
  }

  void measure(const Pose& pose, const Pose& next) {
    const View view = make_view(pose, options_.width, options_.height);
    const View later = make_view(next, options_.width, options_.height);
    fly(view, before_);
    const double tolerance = list_.stats.tolerance_px;
    if (options_.dump) dump_frame(*options_.dump, report_.frames, before_, view);
    check(before_, &view);
    report_.background_pixels +=
        background_pixels(draw_depth_(view, list_, engine_), before_, reference_.world_from_post(),
                          view, options_.threads);
    check_error(measure_residuals(before_, reference_, view, options_.threads));
    const double nearest = nearest_m(view);
    if (report_.frames % kWholeEvery == 0) {
      draw(view, whole_, after_);
      check(after_, nullptr);
    }
    fly(later, after_);
    measure_pop({view, later, before_, after_}, std::min(nearest, nearest_m(later)), tolerance);
    count_triangles();
    ++report_.frames;
  }

  VerifyReport report() const {
    VerifyReport r = report_;
    r.claims = claims_at(r.max_tolerance_px);
    r.max_error_px = residuals_.px.max_px();
    r.p999_error_px = residuals_.px.quantile_px(0.999);
    r.max_error_angular_px = residuals_.max_angular_px;
    r.undrawn_posts = residuals_.undrawn;
    r.max_pop_px = pops_.max_px();
    r.p999_pop_px = pops_.quantile_px(0.999);
    r.mean_triangles = r.frames == 0 ? 0 : triangles_ / r.frames;
    return r;
  }

 private:
  void fit_to_gpu() {
    const lod::Footprint method = engine_.footprint();
    const std::uint64_t room = gl_->vertex_room(method.index_bytes, method.batches);
    if (room < method.least.vertex_bytes) {
      throw Error(ErrorCode::Limit,
                  fmt::format("--gpu-memory: a picture's share leaves {} bytes for vertices, the "
                              "coarsest surface takes {}: allow more",
                              room, method.least.vertex_bytes));
    }
    refine_.budget.vertex_bytes = std::min(refine_.budget.vertex_bytes, room);
  }

  lod::Claims claims_at(double tolerance_px) const {
    lod::RefineOptions used = refine_;
    used.tolerance_px = tolerance_px;
    return engine_.claims(used);
  }

  // A frame of the flight; the whole domain, of which most is out of sight, is none.
  void fly(const View& view, mesh::Surface& out) {
    draw(view, refine_, out);
    const RefineStats& stats = list_.stats;
    report_.achieved_error_px = std::max(report_.achieved_error_px, stats.achieved_error_px);
    report_.max_tolerance_px = std::max(report_.max_tolerance_px, stats.tolerance_px);
  }

  void draw(const View& view, const lod::RefineOptions& how, mesh::Surface& out) {
    engine_.refine(view, how, list_);
    mesh::flatten(list_, engine_, out);
    const RefineStats& stats = list_.stats;
    const std::uint64_t bytes = std::max(named_bytes(list_, engine_), stats.resident_bytes);
    report_.max_vertex_bytes = std::max(report_.max_vertex_bytes, bytes);
    const lod::Budget& cap = how.budget;
    // The least tolerance that fits leaves no cap nearly empty.
    const bool coarse_for_nothing = stats.tolerance_px > how.tolerance_px &&
                                    out.triangles() < cap.triangles / 8 &&
                                    named_bytes(list_, engine_) < cap.vertex_bytes / 8;
    const bool over =
        out.triangles() > cap.triangles || bytes > cap.vertex_bytes || coarse_for_nothing;
    if (over) ++report_.over_budget_frames;
  }

  void check_error(const Residuals& residuals) {
    const lod::Claims claims = claims_at(list_.stats.tolerance_px);
    const double own = list_.stats.achieved_error_px;
    const bool angular = refine_.scale == ErrorScale::Angular;
    const double px = std::min(claims.error_px, angular ? claims.error_px : own);
    const double angle = std::min(claims.error_angular_px, angular ? own : claims.error_angular_px);
    if (residuals.px.max_px() > px + kRoundingPx || residuals.max_angular_px > angle + kRoundingPx)
      ++report_.broken_bounds;
    residuals_.merge(residuals);
  }

  double nearest_m(const View& view) const {
    return nearest_batch_m(list_, engine_, reference_.world_from_post(), view.eye);
  }

  void check(const mesh::Surface& surface, const View* view) {
    const mesh::SurfaceReport r = mesh::check_surface(surface, dem_, view, options_.threads);
    report_.cracks += r.cracks();
    report_.t_junctions += r.t_junctions;
  }

  // A tolerance that a budget changed moves the surface as a change of alpha does.
  void measure_pop(const FramePair& pair, double nearest, double tolerance_before) {
    const double tolerance_after = list_.stats.tolerance_px;
    const PixelHistogram pops = measure_pops(pair, reference_, options_.threads);
    const double motion =
        relative_motion(pair.view_before, pair.view_after, refine_.scale, nearest) +
        relative_change(tolerance_before, tolerance_after);
    const lod::Claims claims = claims_at(std::max(tolerance_before, tolerance_after));
    if (std::isinf(motion)) ++report_.unpromised_pairs;
    report_.max_pop_share =
        std::max(report_.max_pop_share,
                 pop_share(std::max(0.0, pops.max_px() - kRoundingPx), claims.pop_px, motion));
    pops_.merge(pops);
  }

  void count_triangles() {
    triangles_ += static_cast<double>(before_.triangles());
    report_.max_triangles = std::max<std::uint64_t>(report_.max_triangles, before_.triangles());
  }

  lod::Engine& engine_;
  const Heightfield& dem_;
  const VerifyOptions& options_;
  lod::RefineOptions refine_ = options_.refine;
  Reference reference_;
  DrawDepth draw_depth_ = options_.draw_depth;
  std::unique_ptr<GlPicture> gl_;
  lod::RefineOptions whole_;
  DrawList list_;
  mesh::Surface before_, after_;
  Residuals residuals_;
  PixelHistogram pops_;
  double triangles_ = 0;
  VerifyReport report_;
};

}  // namespace

bool VerifyReport::holds() const {
  const bool conforms =
      cracks == 0 && t_junctions == 0 && background_pixels == 0 && undrawn_posts == 0;
  return (conforms || !claims.conforming) && broken_bounds == 0 && over_budget_frames == 0 &&
         max_pop_share <= 1;
}

VerifyReport verify(lod::Engine& engine, const Heightfield& dem, const scene::Path& path,
                    const VerifyOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  Flight flight(engine, dem, options);
  for (int i = 0; i < options.frames; ++i) {
    const double t = path.duration() * i / options.frames;
    flight.measure(path.at(t), path.at(t + kPairSeconds));
    if (options.progress) options.progress((i + 1.0) / options.frames);
  }
  VerifyReport report = flight.report();
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return report;
}

}  // namespace arete::proof
