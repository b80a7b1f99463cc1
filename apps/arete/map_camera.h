#pragma once

#include <glm/glm.hpp>

#include "arete/core/view.h"

#include "ground.h"

namespace arete::app {

// Map controls as functions of the camera: no window, no state.

/// The camera moved level so that `grabbed`, a point of the world, appears under the cursor
/// (pixels of `view`, y down). The same camera when the cursor is at or beyond the horizon.
Pose panned(const View& view, glm::dvec3 grabbed, glm::dvec2 cursor);

/// The camera moved so that its distance to `pivot` is multiplied; pivot stays where it appears.
Pose zoomed(const View& view, glm::dvec3 pivot, double factor);

/// The camera turned by these angles, radians, with pivot staying where it appears. The pitch stays
/// within 89 degrees of the horizon.
Pose turned(const View& view, glm::dvec3 pivot, double yaw, double pitch);

/// The camera lifted, if need be, to `clearance` metres above the ground.
Pose lifted(const Pose& pose, const LeveledGround& ground, double clearance);

/// The whole terrain seen from the south, 40 degrees from above, as near as the viewport's shape
/// (width over height) lets it fit.
Pose home_pose(const scene::Ground& ground, double aspect);

/// The pose of a view.
Pose pose_of(const View& view);

}  // namespace arete::app
