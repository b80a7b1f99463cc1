#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "arete/core/build_context.h"
#include "arete/core/draw_list.h"
#include "arete/core/screen_error.h"
#include "arete/core/view.h"
#include "arete/store/build.h"
#include "arete/store/terrain.h"

namespace arete::lod {

/// Options of a method by name, as text; an unknown name or a bad value is Error Usage.
using Params = std::map<std::string, std::string, std::less<>>;

/// What to do about a tile that is not in memory: read it now, or draw coarser and ask for it.
enum class OnMissing { Wait, Defer };

/// Hard caps on one engine. Before one would break, frames are drawn with a larger tolerance
/// (RefineStats::tolerance_px): the least, to 0.1 %, whose triangles and vertices fit.
struct Budget {
  static constexpr std::uint64_t kUnlimited = std::numeric_limits<std::uint64_t>::max();
  std::uint64_t triangles = kUnlimited;  ///< drawn in a frame
  /// Vertices that the engine holds, and hence that a list names; and indices, where they are made
  /// for the view. Without a cap an engine keeps what the frame needs and a fair number more.
  std::uint64_t vertex_bytes = kUnlimited;
  friend bool operator==(const Budget&, const Budget&) = default;
};

/// What an opened method takes, whatever the view.
struct Footprint {
  std::uint64_t table_bytes = 0;  ///< in memory as long as it is open
  std::uint64_t index_bytes = 0;  ///< of all index blocks that lists may name
  std::uint64_t batches = 0;      ///< at most in a list
  Budget least{0, 0};             ///< what the coarsest surface needs, nothing culled
};

/// Throws: Limit when not even the coarsest surface fits the budget, naming the terrain, the cap
/// and the least that would do.
void require_room(const Footprint& footprint, const Budget& budget, std::string_view terrain);

struct RefineOptions {
  double tolerance_px = 1;
  ErrorScale scale = ErrorScale::Upright;
  OnMissing on_missing = OnMissing::Wait;
  bool cull = true;    ///< drop what the frustum cannot see
  Budget budget = {};  ///< at least the engine's Footprint::least
};

/// What a method promises with the options that it was opened with; infinity = no promise.
struct Claims {
  bool conforming = false;
  double error_px = 0;  ///< drawn surface to full surface, on the screen
  /// Motion of the drawn surface between two frames, in px, per unit of relative motion
  /// |dP| / D + |dalpha| / alpha, D = distance from the eye to the nearest drawn tile.
  double pop_px = 0;
  /// The same as an angle, alpha_ang delta / D: what ErrorScale::Angular bounds.
  double error_angular_px = std::numeric_limits<double>::infinity();
};

/// One opened method. Thread contract: one thread at a time; two engines may share a Terrain.
class Engine : public BlockSource {
 public:
  /// Fills `out` for the view. The same view gives the same list unless the method's README says
  /// coherent. Never throws for missing or damaged tiles: they are drawn coarser and counted.
  virtual void refine(const View& view, const RefineOptions& options, DrawList& out) = 0;
  /// Of frames whose RefineStats::tolerance_px is the options' tolerance.
  virtual Claims claims(const RefineOptions& options) const = 0;
  virtual Footprint footprint() const = 0;
};

/// A row of the table of methods.
struct EngineInfo {
  std::string_view name;      ///< as on the command line
  std::string_view citation;  ///< key in docs/papers.bib
  std::string_view summary;   ///< one line
  /// Writes the segments that open() needs. Throws: as building does.
  void (*preprocess)(const store::Terrain&, store::Writers&, const BuildContext&, const Params&);
  /// Throws: Usage for bad params, NotFound when a segment is missing (naming the build command).
  std::unique_ptr<Engine> (*open)(const store::Terrain&, const Params&);
};

/// All methods, reference first.
std::span<const EngineInfo> engines();
/// Throws: Usage, listing the names.
const EngineInfo& find_engine(std::string_view name);

}  // namespace arete::lod
