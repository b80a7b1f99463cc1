#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>

#include "arete/core/georef.h"
#include "arete/mesh/surface.h"

namespace arete::mesh {

struct WriteOptions {
  Affine2 world_from_post;
  /// Which triangles to write, by the posts of their corners; empty = all.
  std::function<bool(const std::array<Post, 3>&)> keep;
};

/// What a mesh file holds.
struct MeshSize {
  std::uint64_t triangles = 0, vertices = 0;
};

/// Throws: Usage for a name that write_mesh would refuse.
void check_mesh_name(const std::filesystem::path& file);

/// Writes the surface in world metres, vertices at the same place merged: .obj, .ply (binary),
/// .stl (binary), .glb (glTF 2.0, y up, placed by a node so that floats suffice), by extension.
/// Throws: Usage for another extension, InvalidInput for no triangle, Limit when the format
/// cannot hold so much, Io; nothing is left behind then, and an older file of that name is kept.
MeshSize write_mesh(const std::filesystem::path& file, const Surface& surface,
                    const WriteOptions& options);

/// Binary PLY in grid coordinates: x = column, y = row, z = metres, as drawn, float.
/// Throws: Io, as write_mesh.
void write_grid_ply(const std::filesystem::path& file, const Surface& surface);

}  // namespace arete::mesh
