#pragma once

#include <cmath>

#include "ground.h"

namespace arete::app {

/// Smooth hills of up to 2 x 40 m on 101 x 81 posts, 30 m apart, north up; alike at every level.
inline LeveledGround hills() {
  LeveledGround ground;
  static_cast<scene::Ground&>(ground) = {101, 81, {{30, 0, 0, 0, -30, 0}}, -80, 80, {}};
  ground.height = [](double col, double row) {
    return 40 * std::sin(col / 7) + 40 * std::cos(row / 5);
  };
  ground.height_of_level = [height = ground.height](double col, double row, int, store::Fetch) {
    return height(col, row);
  };
  return ground;
}

}  // namespace arete::app
