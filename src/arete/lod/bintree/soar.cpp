#include "arete/lod/bintree/soar.h"

#include <limits>

#include <fmt/format.h>

#include "arete/core/error.h"
#include "arete/lod/bintree/coarsening.h"
#include "arete/lod/bintree/engine_parts.h"
#include "arete/lod/params.h"

namespace arete::lod::bintree {
namespace {

/// Two thirds of the tolerance is where morphing begins: what a public port of SOAR takes.
constexpr double kMorphSharper = 1.5;

/// Writes one strip: a vertex is added unless it is one of the last two; where the parity does not
/// turn, a repeated vertex does [LindstromPascucci2002].
class Strip {
 public:
  /// `outer`: the whole tolerance, `inner`: what the walk goes by, no larger.
  Strip(DrawList& out, const Criterion& outer, const Criterion& inner)
      : out_(out), outer_(outer), inner_(inner) {}

  void begin(Corner& first) {
    older_ = newer_ = {first.post, place(first)};
    out_.indices.assign(3, first.slot);  // the third turns the winding to ours
  }
  void halved(Corner& apex, int levels) { append(apex, static_cast<unsigned>(levels) & 1U); }
  void whole(Corner& apex, Corner&, Corner&, int levels) { halved(apex, levels); }
  void root_done(Corner& right) {
    if (++roots_ < 4) {
      append(right, 0);
    } else {
      out_.indices.push_back(place(right));
    }
  }

  // z' = ((d_max - d) z + (d - d_min) (z_l' + z_r') / 2) / (d_max - d_min), d = |P - v|^2
  // [LindstromPascucci2002; METHODS 3.2].
  void morph(Corner& corner, const Ball& ball, const Corner& l, const Corner& r) {
    const glm::dvec3 to = ball.centre - inner_.eye();
    const double d = glm::dot(to, to);  // below `none`: the vertex is active
    const double full = outer_.reach(ball) * outer_.reach(ball);
    if (!(d > full)) return;
    const double none = inner_.reach(ball) * inner_.reach(ball);
    const double share = (d - full) / (none - full);
    const double flat = (static_cast<double>(l.z) + static_cast<double>(r.z)) / 2;
    corner.z = static_cast<float>(ball.centre.z + share * (flat - ball.centre.z));
  }

 private:
  /// A vertex in the strip.
  struct Laid {
    Post post;
    std::uint32_t slot = 0;
  };

  void append(Corner& v, unsigned parity) {
    if (v.post == newer_.post || v.post == older_.post) return;
    if (parity == parity_) {
      out_.indices.push_back(older_.slot);  // a turn: the older one stays
    } else {
      older_ = newer_;
    }
    newer_ = {v.post, place(v)};
    out_.indices.push_back(newer_.slot);
    parity_ = parity;
  }

  std::uint32_t place(Corner& v) {
    if (v.slot == Corner::kNone) {
      v.slot = static_cast<std::uint32_t>(out_.vertices.size());
      out_.vertices.push_back({.post = v.post, .z = v.z});
    }
    return v.slot;
  }

  DrawList& out_;
  const Criterion &outer_, &inner_;
  Laid older_, newer_;
  unsigned parity_ = 1;
  int roots_ = 0;
};

class SoarEngine final : public Engine {
 public:
  SoarEngine(const store::Terrain& terrain, const RecordPages::Options& options, double sharper)
      : ground_(terrain, options), delta_(options.delta), sharper_(sharper) {}

  void refine(const View& view, const RefineOptions& options, DrawList& out) override {
    out.clear();
    if (!ground_.has_cells()) return;
    ground_.pages().begin_frame();
    ScreenError error = asked_error(view, options);
    Findings found = draw(view, error, options, out);
    out.stats.tolerance_px = options.tolerance_px;
    if (!Need{found.halved}.fits(options.budget)) {
      error = fitting_error(ground_, view, options);
      out.stats.tolerance_px = kept_tolerance_px(ground_, view, error);
      found = draw(view, error, options, out);
    }
    report(ground_, found, out.stats);
    out.stats.resident_bytes = out.vertices.size() * sizeof(Vertex) +  //
                               out.indices.size() * sizeof(std::uint32_t);
    out.batches.push_back({.index_count = static_cast<std::uint32_t>(out.indices.size()),
                           .error = error_m(found),
                           .topology = Topology::Strip});
  }

  Claims claims(const RefineOptions& options) const override {
    const bool bounded = delta_ == Delta::Exact && sharper_ == 1;
    return claims_of(options, bounded ? Bounded::Yes : Bounded::No);
  }
  Footprint footprint() const override {
    return {.table_bytes = ground_.pages().table_bytes(), .batches = 1, .least = least_budget()};
  }

  // Everything that it draws is in the list.
  std::span<const Vertex> vertices(BlockKey) const override { return {}; }
  std::span<const std::uint32_t> indices(BlockKey) const override { return {}; }

 private:
  Findings draw(const View& view, const ScreenError& error, const RefineOptions& options,
                DrawList& out) {
    const Criterion outer(view, error);
    const Criterion inner(view, error, sharper_);
    const Rule rule{inner, error, options};
    const Findings found = draw(rule, outer, nullptr, out);
    if (found.late == 0) return found;
    // What hangs on a missing vertex by its other parent goes as well.
    Presence presence(ground_, options.on_missing);
    return draw(rule, outer, &presence, out);
  }

  Findings draw(const Rule& rule, const Criterion& outer, Presence* presence, DrawList& out) {
    out.vertices.clear();
    out.indices.clear();
    Strip strip(out, outer, rule.criterion);
    Walk<Strip> walk(ground_, rule, strip);
    walk.use(presence);
    walk.refine_all();
    return walk.findings();
  }

  Ground ground_;
  Delta delta_;
  double sharper_;
};

}  // namespace

std::unique_ptr<Engine> open_soar(const store::Terrain& terrain, const Params& params) {
  check_names(params, {"delta", "morph", "pages", "prefetch"});
  const bool morph = flag_param(params, "morph");
  return std::make_unique<SoarEngine>(terrain, page_options(params), morph ? kMorphSharper : 1);
}

}  // namespace arete::lod::bintree
