#pragma once

#include <vector>

#include "arete/scene/path.h"

namespace arete::scene {

/// The lengths that flights are made of, metres.
struct Scale {
  double spacing;  ///< of posts
  double extent;   ///< longer side of the grid, at least one spacing
};
Scale scale_of(const Ground& ground);

/// Ground height under a world point.
double ground_at(const Ground& ground, glm::dvec2 world);

/// The closed minute of DESIGN.md section 5.
Path fly_over(const Ground& ground);

/// The path of the keyframes, raised where it would come nearer to the ground than `margin_m`,
/// between keyframes too. Equal neighbours stay equal.
Path raise_above_ground(std::vector<Keyframe> keyframes, const Ground& ground, double margin_m);

}  // namespace arete::scene
