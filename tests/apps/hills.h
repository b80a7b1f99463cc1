#pragma once

#include <cmath>

#include "arete/scene/path.h"

namespace arete::app {

/// Smooth hills of up to 2 x 40 m on 101 x 81 posts, 30 m apart, north up.
inline scene::Ground hills() {
  scene::Ground ground{101, 81, {{30, 0, 0, 0, -30, 0}}, -80, 80, {}};
  ground.height = [](double col, double row) {
    return 40 * std::sin(col / 7) + 40 * std::cos(row / 5);
  };
  return ground;
}

}  // namespace arete::app
