#pragma once

#include <filesystem>

#include "arete/core/view.h"
#include "arete/mesh/surface.h"

namespace arete::proof {

/// Writes `directory`/frame_NNNNN.ply (x = column, y = row, z = metres, as drawn) and the camera
/// beside it as .json: eye, yaw, pitch, fovy, near, viewport, clip_from_world (four rows; reversed
/// depth), in metres and radians. Makes the directory. Throws: Io.
void dump_frame(const std::filesystem::path& directory, int frame, const mesh::Surface& surface,
                const View& view);

}  // namespace arete::proof
