#include "arete/mesh/write.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <limits>
#include <numeric>
#include <string>
#include <tuple>
#include <vector>

#include <fmt/format.h>

#include "arete/core/error.h"
#include "arete/mesh/new_file.h"

namespace arete::mesh {
namespace {

static_assert(std::endian::native == std::endian::little, "the formats are little-endian");

// Positions in the file's coordinates, vertices at the same place merged.
struct Mesh {
  std::vector<glm::dvec3> points;
  std::vector<std::uint32_t> indices;
};

auto place_of(const SurfaceVertex& v) {
  return std::make_tuple(v.post.row, v.post.col, v.drow, v.dcol, v.z);
}

// For each vertex the first one, in the order of places, that lies at the same place.
std::vector<std::uint32_t> merged_vertices(const Surface& s) {
  std::vector<std::uint32_t> order(s.vertices.size());
  std::iota(order.begin(), order.end(), 0U);
  std::ranges::stable_sort(order, [&](std::uint32_t a, std::uint32_t b) {
    return place_of(s.vertices[a]) < place_of(s.vertices[b]);
  });
  std::vector<std::uint32_t> first(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool same = i > 0 && place_of(s.vertices[order[i - 1]]) == place_of(s.vertices[order[i]]);
    first[order[i]] = same ? first[order[i - 1]] : order[i];
  }
  return first;
}

glm::dvec3 grid_position(const SurfaceVertex& v) {
  return {double{v.dcol} + v.post.col, double{v.drow} + v.post.row, double{v.z}};
}

template <typename Position>
Mesh make_mesh(const Surface& s, const WriteOptions& options, const Position& position) {
  constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  const std::vector<std::uint32_t> first = merged_vertices(s);
  std::vector<std::uint32_t> number(s.vertices.size(), kNone);
  Mesh mesh;
  for (std::size_t i = 0; i + 3 <= s.indices.size(); i += 3) {
    const auto corner = [&](std::size_t k) { return s.vertices[s.indices[i + k]].post; };
    if (options.keep && !options.keep({corner(0), corner(1), corner(2)})) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t v = first[s.indices[i + k]];
      if (number[v] == kNone) {
        number[v] = static_cast<std::uint32_t>(mesh.points.size());
        mesh.points.push_back(position(s.vertices[v]));
      }
      mesh.indices.push_back(number[v]);
    }
  }
  return mesh;
}

std::vector<float> to_floats(const std::vector<glm::dvec3>& points) {
  std::vector<float> out;
  out.reserve(3 * points.size());
  for (const glm::dvec3& p : points) {
    for (int k = 0; k < 3; ++k) out.push_back(static_cast<float>(p[k]));
  }
  return out;
}

void write_obj(NewFile& out, const Mesh& mesh) {
  fmt::memory_buffer text;
  const auto flush = [&](std::size_t at_least) {
    if (text.size() < at_least) return;
    out.write(std::string_view(text.data(), text.size()));
    text.clear();
  };
  constexpr std::size_t kChunk = std::size_t{1} << 16U;
  for (const glm::dvec3& p : mesh.points) {
    fmt::format_to(std::back_inserter(text), "v {:.4f} {:.4f} {:.4f}\n", p.x, p.y, p.z);
    flush(kChunk);
  }
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    fmt::format_to(std::back_inserter(text), "f {} {} {}\n", mesh.indices[i] + 1,
                   mesh.indices[i + 1] + 1, mesh.indices[i + 2] + 1);
    flush(kChunk);
  }
  flush(1);
}

void write_ply(NewFile& out, const Mesh& mesh) {
  out.write(
      fmt::format("ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\n"
                  "property float y\nproperty float z\nelement face {}\n"
                  "property list uchar int vertex_indices\nend_header\n",
                  mesh.points.size(), mesh.indices.size() / 3));
  out.write(std::span<const float>(to_floats(mesh.points)));
  std::vector<char> faces;
  constexpr std::size_t kFaceBytes = 13;
  faces.resize(mesh.indices.size() / 3 * kFaceBytes);
  for (std::size_t f = 0; f < mesh.indices.size() / 3; ++f) {
    char* at = faces.data() + f * kFaceBytes;
    *at = 3;
    std::memcpy(at + 1, &mesh.indices[3 * f], 12);
  }
  out.write(std::span<const char>(faces));
}

void write_stl(NewFile& out, const Mesh& mesh) {
  std::array<char, 80> header{};
  fmt::format_to_n(header.data(), header.size(), "arete terrain, metres");
  out.write(std::span<const char>(header));
  const std::array<std::uint32_t, 1> count{static_cast<std::uint32_t>(mesh.indices.size() / 3)};
  out.write(std::span<const std::uint32_t>(count));
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    const glm::dvec3 a = mesh.points[mesh.indices[i]];
    const glm::dvec3 b = mesh.points[mesh.indices[i + 1]];
    const glm::dvec3 c = mesh.points[mesh.indices[i + 2]];
    const std::vector<float> corners =
        to_floats({glm::normalize(glm::cross(b - a, c - a)), a, b, c});
    std::array<char, 50> facet{};
    std::memcpy(facet.data(), corners.data(), 48);
    out.write(std::span<const char>(facet));
  }
}

// glTF's y is up: (x, z, -y). Points become relative to the returned centre.
glm::dvec3 turn_and_centre(Mesh& mesh) {
  glm::dvec3 lo(std::numeric_limits<double>::infinity());
  glm::dvec3 hi = -lo;
  for (glm::dvec3& p : mesh.points) {
    p = {p.x, p.z, -p.y};
    lo = glm::min(lo, p);
    hi = glm::max(hi, p);
  }
  const glm::dvec3 centre = mesh.points.empty() ? glm::dvec3(0) : glm::round((lo + hi) / 2.0);
  for (glm::dvec3& p : mesh.points) p -= centre;
  return centre;
}

std::string glb_json(const Mesh& mesh, const std::vector<float>& positions, glm::dvec3 centre) {
  std::array<float, 3> lo{};
  std::array<float, 3> hi{};
  for (std::size_t k = 0; k < 3 && !positions.empty(); ++k) {
    lo[k] = hi[k] = positions[k];
    for (std::size_t i = k; i < positions.size(); i += 3) {
      lo[k] = std::min(lo[k], positions[i]);
      hi[k] = std::max(hi[k], positions[i]);
    }
  }
  const std::size_t point_bytes = positions.size() * sizeof(float);
  const std::size_t index_bytes = mesh.indices.size() * sizeof(std::uint32_t);
  std::string json = R"({"asset":{"version":"2.0","generator":"arete"},"scene":0,)"
                     R"("scenes":[{"nodes":[0]}],"nodes":[{"mesh":0,)";
  json += fmt::format(R"("translation":[{},{},{}]}}],)", centre.x, centre.y, centre.z);
  json += R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],)";
  json += fmt::format(R"("buffers":[{{"byteLength":{}}}],)", point_bytes + index_bytes);
  json += fmt::format(R"("bufferViews":[{{"buffer":0,"byteLength":{0},"target":34962}},)"
                      R"({{"buffer":0,"byteOffset":{0},"byteLength":{1},"target":34963}}],)",
                      point_bytes, index_bytes);
  json +=
      fmt::format(R"("accessors":[{{"bufferView":0,"componentType":5126,"count":{},"type":"VEC3",)"
                  R"("min":[{},{},{}],"max":[{},{},{}]}},)",
                  mesh.points.size(), lo[0], lo[1], lo[2], hi[0], hi[1], hi[2]);
  json += fmt::format(R"({{"bufferView":1,"componentType":5125,"count":{},"type":"SCALAR"}}]}})",
                      mesh.indices.size());
  json.resize((json.size() + 3) / 4 * 4, ' ');
  return json;
}

void write_glb(NewFile& out, Mesh mesh, const std::string& name) {
  const glm::dvec3 centre = turn_and_centre(mesh);
  const std::vector<float> positions = to_floats(mesh.points);
  const std::string json = glb_json(mesh, positions, centre);
  const std::size_t bytes = 4 * (positions.size() + mesh.indices.size());
  const std::size_t total = 28 + json.size() + bytes;
  if (total > std::numeric_limits<std::uint32_t>::max()) {
    throw Error(ErrorCode::Limit,
                fmt::format("{}: more than 4 GiB, which glTF cannot hold: write .ply or allow a "
                            "larger error",
                            name));
  }
  const auto u32 = [](std::size_t n) { return static_cast<std::uint32_t>(n); };
  const std::array<std::uint32_t, 5> head{0x46546C67U, 2U, u32(total), u32(json.size()),
                                          0x4E4F534AU};
  const std::array<std::uint32_t, 2> chunk{u32(bytes), 0x004E4942U};
  out.write(std::span<const std::uint32_t>(head));
  out.write(json);
  out.write(std::span<const std::uint32_t>(chunk));
  out.write(std::span<const float>(positions));
  out.write(std::span<const std::uint32_t>(mesh.indices));
}

}  // namespace

void check_mesh_name(const std::filesystem::path& file) {
  const std::string kind = file.extension().string();
  if (kind != ".obj" && kind != ".ply" && kind != ".stl" && kind != ".glb") {
    throw Error(ErrorCode::Usage, fmt::format("{}: unknown kind of mesh: name it .obj, .ply, .stl "
                                              "or .glb",
                                              file.string()));
  }
}

MeshSize write_mesh(const std::filesystem::path& file, const Surface& surface,
                    const WriteOptions& options) {
  check_mesh_name(file);
  const std::string kind = file.extension().string();
  const Mesh mesh = make_mesh(surface, options, [&](const SurfaceVertex& v) {
    const glm::dvec3 grid = grid_position(v);
    return glm::dvec3(options.world_from_post.apply(grid.x, grid.y), grid.z);
  });
  if (mesh.indices.empty()) {
    throw Error(ErrorCode::InvalidInput,
                fmt::format("{}: there is no triangle to write: check that the terrain has cells "
                            "with data",
                            file.string()));
  }
  NewFile out(file);
  if (kind == ".obj") write_obj(out, mesh);
  if (kind == ".ply") write_ply(out, mesh);
  if (kind == ".stl") write_stl(out, mesh);
  if (kind == ".glb") write_glb(out, mesh, file.string());
  out.publish();
  return {mesh.indices.size() / 3, mesh.points.size()};
}

void write_grid_ply(const std::filesystem::path& file, const Surface& surface) {
  NewFile out(file);
  write_ply(out, make_mesh(surface, {}, grid_position));
  out.publish();
}

}  // namespace arete::mesh
