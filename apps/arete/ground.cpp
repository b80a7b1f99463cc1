#include "ground.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <vector>

namespace arete::app {
namespace {

using store::Fetch;
using store::kTileCells;
using store::kTilePosts;

/// Bilinear heights of single posts. Keeps the last tile of each level, for neighbouring questions
/// come one after another.
class Heights {
 public:
  explicit Heights(const store::Terrain& terrain)
      : terrain_(terrain), last_(static_cast<std::size_t>(terrain.levels())) {}

  double at(glm::dvec2 post, int level, Fetch fetch) {
    const store::Manifest& m = terrain_.manifest();
    const int top = terrain_.levels() - 1;
    post = glm::clamp(post, glm::dvec2(0), glm::dvec2(m.cols - 1, m.rows - 1));
    for (int l = std::clamp(level, 0, top); l <= top; ++l) {
      if (const auto z = in_level(l, post, l == top ? Fetch::Wait : fetch)) {
        return *z;
      }
      if (fetch == Fetch::Resident) {
        fetch = Fetch::Held;  // only the level that was wanted is worth asking for
      }
    }
    return m.z_min;
  }

 private:
  struct Last {
    TileId id;
    std::shared_ptr<const store::HeightTile> tile;
  };

  const store::HeightTile* find(TileId id, Fetch fetch) {
    Last& last = last_[id.level];
    if (!last.tile || last.id != id) {
      if (auto tile = terrain_.heights(id, fetch)) {
        last = {id, std::move(tile)};
      } else {
        return nullptr;
      }
    }
    return last.tile.get();
  }

  std::optional<double> in_level(int level, glm::dvec2 post, Fetch fetch) {
    const glm::dvec2 p = post / std::exp2(level);
    const glm::ivec2 tile =
        glm::min(glm::ivec2(p) / kTileCells,
                 glm::ivec2(terrain_.tiles_x(level), terrain_.tiles_y(level)) - 1);
    const auto* const heights =
        find({static_cast<std::uint32_t>(level), static_cast<std::uint32_t>(tile.x),
              static_cast<std::uint32_t>(tile.y)},
             fetch);
    if (heights == nullptr) {
      return std::nullopt;
    }
    const glm::dvec2 local = p - glm::dvec2(tile * kTileCells);
    const glm::ivec2 cell = glm::clamp(glm::ivec2(local), 0, kTileCells - 1);
    const glm::dvec2 t = glm::clamp(local - glm::dvec2(cell), 0.0, 1.0);
    const auto z = [&](int i, int j) {
      return terrain_.z_of(
          heights->counts[static_cast<std::size_t>((cell.y + j) * kTilePosts + cell.x + i)]);
    };
    return std::lerp(std::lerp(z(0, 0), z(1, 0), t.x), std::lerp(z(0, 1), z(1, 1), t.x), t.y);
  }

  const store::Terrain& terrain_;
  std::vector<Last> last_;  ///< by level
};

}  // namespace

LeveledGround ground_of(const store::Terrain& terrain, Fetch fetch) {
  const store::Manifest& m = terrain.manifest();
  const auto heights = std::make_shared<Heights>(terrain);
  LeveledGround ground;
  static_cast<scene::Ground&>(ground) = {m.cols,  m.rows,  m.georef.world_from_post,
                                         m.z_min, m.z_max, {}};
  ground.height = [heights, fetch](double col, double row) {
    return heights->at({col, row}, 0, fetch);
  };
  ground.height_of_level = [heights](double col, double row, int level, Fetch how) {
    return heights->at({col, row}, level, how);
  };
  return ground;
}

double post_spacing(const scene::Ground& ground) {
  return std::sqrt(std::abs(ground.world_from_post.determinant()));
}

int level_for_distance(const scene::Ground& ground, double distance_m) {
  constexpr double kShare = 0.002;
  const double posts = kShare * distance_m / post_spacing(ground);
  return posts > 1 ? static_cast<int>(std::log2(posts)) : 0;
}

double ground_height(const scene::Ground& ground, glm::dvec2 world) {
  const glm::dvec2 post = ground.world_from_post.inverse(world);
  return ground.height(post.x, post.y);
}

double height_below(const LeveledGround& ground, glm::dvec3 eye) {
  const glm::dvec2 post = ground.world_from_post.inverse(glm::dvec2(eye));
  // From the lowest ground the eye stands highest: each look can only ask for a finer level.
  int level = level_for_distance(ground, eye.z - ground.z_min);
  while (true) {
    const double z = ground.height_of_level(post.x, post.y, level, Fetch::Wait);
    const int finer = level_for_distance(ground, eye.z - z);
    if (finer >= level) {
      return z;
    }
    level = finer;
  }
}

}  // namespace arete::app
