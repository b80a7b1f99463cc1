#pragma once

#include <functional>

#include "arete/scene/path.h"
#include "arete/store/terrain.h"

namespace arete::app {

/// Ground that also answers coarsely, as a ray that looks far wants it.
struct LeveledGround : scene::Ground {
  /// Height in metres at a fractional post (column, row) from the tile of this level or, where that
  /// cannot be had in this way, of the next coarser one that can.
  std::function<double(double, double, int, store::Fetch)> height_of_level;
};

/// Heights of the finest tiles, read as they are needed (Wait), or of the finest that are in
/// memory (Resident asks for the finest; the one tile of the coarsest level is then read). Lives as
/// long as `terrain`. Thread contract: one thread.
LeveledGround ground_of(const store::Terrain& terrain, store::Fetch fetch);

/// Metres between posts, as the square root of a cell's area.
double post_spacing(const scene::Ground& ground);

/// The level whose posts stand about a 500th of the distance apart: less than a pixel or two.
int level_for_distance(const scene::Ground& ground, double distance_m);

/// Height of the ground in metres at a world position; the grid's edge goes on outside of it.
double ground_height(const scene::Ground& ground, glm::dvec2 world);

/// Height in metres of the ground below the eye, the more exact the nearer it is; reads a tile at
/// most when the eye comes over a new one.
double height_below(const LeveledGround& ground, glm::dvec3 eye);

}  // namespace arete::app
