#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>

#include "arete/lod/engine.h"
#include "arete/render/renderer.h"

#include "flags.h"
#include "ground.h"
#include "land_rasters.h"
#include "open_store.h"
#include "place.h"

namespace arete::app {

/// A terrain with one method opened on it: all of a ShownTerrain that any thread can make.
struct OpenedTerrain {
  std::filesystem::path source;  ///< as the user named it
  std::unique_ptr<store::Terrain> terrain;
  std::string method;
  std::unique_ptr<lod::Engine> engine;
  bool preview = false;  ///< the store is still being built
};

/// Opens the store that was made of flags.terrain. Throws: as opening the store and the method
/// does.
OpenedTerrain open_with_method(const TerrainFlags& flags, const std::filesystem::path& store,
                               const std::string& method);

/// One terrain on the screen: its engine, a renderer, and the latest list.
class ShownTerrain {
 public:
  /// Requires: a current OpenGL context. Throws: as Renderer.
  ShownTerrain(OpenedTerrain opened, std::size_t gpu_memory);

  /// Another method of the same store, drawn by the same renderer. Throws: as opening a method
  /// does; the old one stays then.
  void change_method(const TerrainFlags& flags, const std::string& method);

  void refine(const View& view, const lod::RefineOptions& options);
  /// Draws the latest list, perhaps from another camera than it was refined for.
  void draw(const View& view, const render::Style& style, render::Frame& frame);

  bool refined() const { return refined_; }  ///< false before the first refine of the method
  const store::Terrain& terrain() const { return *opened_.terrain; }
  /// Heights for the camera (exact ones are waited for) and for the cursor (they are asked for).
  const LeveledGround& ground() const { return ground_; }
  const LeveledGround& cursor_ground() const { return cursor_ground_; }
  const Place& place() const { return place_; }
  /// The least budget that the method can keep.
  lod::Budget least_budget() const { return footprint_.least; }
  /// Memory that grows with the terrain: what --cache caps.
  std::uint64_t bytes() const;
  /// As budget_of. Throws: Limit.
  lod::Budget budget_under(const FlightFlags& flags) const;
  const std::filesystem::path& source() const { return opened_.source; }
  bool preview() const { return opened_.preview; }
  const std::string& method() const { return opened_.method; }
  const RefineStats& refine_stats() const { return list_.stats; }
  const render::DrawStats& draw_stats() const { return renderer_.stats(); }

 private:
  OpenedTerrain opened_;
  lod::Footprint footprint_;  ///< of the engine, which sums it up anew each time it is asked
  LandRasters rasters_;
  LeveledGround ground_, cursor_ground_;
  Place place_;
  render::Renderer renderer_;
  DrawList list_;
  bool refined_ = false;
};

}  // namespace arete::app
