#include "ground.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace arete::app {
namespace {

/// Bilinear height within the tile of this level that holds the post; nothing without the tile.
std::optional<double> height_at(const store::Terrain& terrain, int level, glm::dvec2 post,
                                store::Fetch fetch) {
  const glm::dvec2 p = post / std::exp2(level);
  const glm::ivec2 tile = glm::min(glm::ivec2(p) / store::kTileCells,
                                   glm::ivec2(terrain.tiles_x(level), terrain.tiles_y(level)) - 1);
  const auto heights =
      terrain.heights({static_cast<std::uint32_t>(level), static_cast<std::uint32_t>(tile.x),
                       static_cast<std::uint32_t>(tile.y)},
                      fetch);
  if (!heights) {
    return std::nullopt;
  }
  const glm::dvec2 local = p - glm::dvec2(tile * store::kTileCells);
  const glm::ivec2 cell = glm::clamp(glm::ivec2(local), 0, store::kTileCells - 1);
  const glm::dvec2 t = glm::clamp(local - glm::dvec2(cell), 0.0, 1.0);
  const auto z = [&](int i, int j) {
    return terrain.z_of(
        heights->counts[static_cast<std::size_t>((cell.y + j) * store::kTilePosts + cell.x + i)]);
  };
  return std::lerp(std::lerp(z(0, 0), z(1, 0), t.x), std::lerp(z(0, 1), z(1, 1), t.x), t.y);
}

}  // namespace

scene::Ground ground_of(const store::Terrain& terrain, store::Fetch fetch) {
  const store::Manifest& m = terrain.manifest();
  scene::Ground ground{m.cols, m.rows, m.georef.world_from_post, m.z_min, m.z_max, {}};
  ground.height = [&terrain, &m, fetch](double col, double row) {
    const glm::dvec2 post =
        glm::clamp(glm::dvec2(col, row), glm::dvec2(0), glm::dvec2(m.cols - 1, m.rows - 1));
    const int top = terrain.levels() - 1;
    for (int level = 0; level <= top; ++level) {
      if (const auto z =
              height_at(terrain, level, post, level == top ? store::Fetch::Wait : fetch)) {
        return *z;
      }
    }
    return m.z_min;
  };
  return ground;
}

}  // namespace arete::app
