#include "arete/proof/verify.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <utility>

#include "arete/mesh/surface.h"
#include "arete/proof/dump.h"
#include "arete/proof/pop.h"
#include "arete/proof/reference.h"
#include "arete/proof/residual.h"

namespace arete::proof {
namespace {

constexpr double kPairSeconds = 1.0 / 60;
constexpr int kWholeEvery = 10;  // every so many frames the whole domain is checked, too

class Flight {
 public:
  Flight(lod::Engine& engine, const Heightfield& dem, const VerifyOptions& options)
      : engine_(engine), dem_(dem), options_(options), reference_(dem, options.threads) {
    if (!draw_depth_) {
      gl_ = std::make_unique<GlPicture>(dem);
      draw_depth_ = [this](const View& v, const DrawList& list, const BlockSource& blocks) {
        return gl_->depth(v, list, blocks);
      };
    }
    report_.claims = engine.claims(options.refine);
    report_.tolerance_px = options.refine.tolerance_px;
    whole_ = options.refine;
    whole_.cull = false;
  }

  void measure(const Pose& pose, const Pose& next) {
    const View view = make_view(pose, options_.width, options_.height);
    const View later = make_view(next, options_.width, options_.height);
    draw(view, options_.refine, before_);
    if (options_.dump) dump_frame(*options_.dump, report_.frames, before_, view);
    check(before_, &view);
    report_.background_pixels +=
        background_pixels(draw_depth_(view, list_, engine_), before_, reference_.world_from_post(),
                          view, options_.threads);
    residuals_.merge(measure_residuals(before_, reference_, view, options_.threads));
    const double nearest = nearest_m(view);
    if (report_.frames % kWholeEvery == 0) {
      draw(view, whole_, after_);
      check(after_, nullptr);
    }
    draw(later, options_.refine, after_);
    measure_pop({view, later, before_, after_}, std::min(nearest, nearest_m(later)));
    count_triangles();
    ++report_.frames;
  }

  VerifyReport report() const {
    VerifyReport r = report_;
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
  void draw(const View& view, const lod::RefineOptions& how, mesh::Surface& out) {
    engine_.refine(view, how, list_);
    mesh::flatten(list_, engine_, out);
    report_.achieved_error_px = std::max(report_.achieved_error_px, list_.stats.achieved_error_px);
  }

  double nearest_m(const View& view) const {
    return nearest_batch_m(list_, engine_, reference_.world_from_post(), view.eye);
  }

  void check(const mesh::Surface& surface, const View* view) {
    const mesh::SurfaceReport r = mesh::check_surface(surface, dem_, view, options_.threads);
    report_.cracks += r.cracks();
    report_.t_junctions += r.t_junctions;
  }

  void measure_pop(const FramePair& pair, double nearest) {
    const PixelHistogram pops = measure_pops(pair, reference_, options_.threads);
    const double motion =
        relative_motion(pair.view_before, pair.view_after, options_.refine.scale, nearest);
    if (std::isinf(motion)) ++report_.unpromised_pairs;
    report_.max_pop_share = std::max(
        report_.max_pop_share,
        pop_share(std::max(0.0, pops.max_px() - kRoundingPx), report_.claims.pop_px, motion));
    pops_.merge(pops);
  }

  void count_triangles() {
    triangles_ += static_cast<double>(before_.triangles());
    report_.max_triangles = std::max<std::uint64_t>(report_.max_triangles, before_.triangles());
  }

  lod::Engine& engine_;
  const Heightfield& dem_;
  const VerifyOptions& options_;
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
  return (conforms || !claims.conforming) && max_error_px <= claims.error_px + kRoundingPx &&
         max_error_angular_px <= claims.error_angular_px + kRoundingPx && max_pop_share <= 1;
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
