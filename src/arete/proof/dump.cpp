#include "arete/proof/dump.h"

#include <system_error>

#include <fmt/format.h>

#include "arete/core/error.h"
#include "arete/mesh/new_file.h"
#include "arete/mesh/write.h"

namespace arete::proof {
namespace {

std::string matrix_rows(const glm::dmat4& m) {
  std::string out;
  for (int r = 0; r < 4; ++r) {
    out +=
        fmt::format("{}[{}, {}, {}, {}]", r == 0 ? "" : ", ", m[0][r], m[1][r], m[2][r], m[3][r]);
  }
  return out;
}

std::string camera_json(const View& v) {
  return fmt::format(
      "{{\"eye\": [{}, {}, {}], \"yaw\": {}, \"pitch\": {}, \"fovy\": {}, \"near\": {},\n"
      " \"viewport\": [{}, {}],\n \"clip_from_world\": [{}]}}\n",
      v.eye.x, v.eye.y, v.eye.z, v.yaw, v.pitch, v.fovy, v.near_m, v.viewport_width,
      v.viewport_height, matrix_rows(v.clip_from_world));
}

}  // namespace

void dump_frame(const std::filesystem::path& directory, int frame, const mesh::Surface& surface,
                const View& view) {
  std::error_code failure;
  std::filesystem::create_directories(directory, failure);
  if (failure) {
    throw Error(ErrorCode::Io,
                fmt::format("{}: cannot be made: {}", directory.string(), failure.message()));
  }
  const std::string name = fmt::format("frame_{:05}", frame);
  mesh::write_grid_ply(directory / (name + ".ply"), surface);
  mesh::NewFile camera(directory / (name + ".json"));
  camera.write(camera_json(view));
  camera.publish();
}

}  // namespace arete::proof
