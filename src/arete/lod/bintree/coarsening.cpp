#include "arete/lod/bintree/coarsening.h"

#include <cmath>

#include "arete/lod/least_fitting.h"

namespace arete::lod::bintree {
namespace {

struct Count {
  void begin(Corner&) {}
  void halved(Corner&, int) {}
  void whole(Corner&, Corner&, Corner&, int) {}
  void halving(Corner&, const Ball&, const Corner&, const Corner&) {}
  void root_done(Corner&) {}
};

}  // namespace

ScreenError fitting_error(Ground& ground, const View& view, const RefineOptions& options,
                          double sharper) {
  constexpr double kLeastPx = 0x1p-20;  // "every post" has no tolerance to multiply
  const ScreenError base(view, std::max(options.tolerance_px, kLeastPx), options.scale);
  ScreenError used(view, options.tolerance_px, options.scale);
  least_fitting([&](double log_times) {
    if (log_times > 0) used = base.coarser(std::exp(log_times));
    const Criterion criterion(view, used, sharper);
    Count count;
    Walk<Count> walk(ground, {criterion, used, options}, count);
    walk.refine_all();
    return excess(Need{walk.findings().halved}.budget(), options.budget);
  });
  return used;
}

double kept_tolerance_px(const Ground& ground, const View& view, const ScreenError& error) {
  return error.tolerance_px(error.allowed_m(0) > 0 ? ground.nearest_m(view.eye) : 1.0);
}

}  // namespace arete::lod::bintree
