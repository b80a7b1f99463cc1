#include "flight_log.h"

#include <cerrno>
#include <cmath>
#include <limits>
#include <system_error>

#include <fmt/format.h>

#include "arete/core/error.h"

namespace arete::app {

FlightLog::FlightLog(const std::filesystem::path& file) : file_(file), out_(file) {
  out_ << "frame,seconds,frame_ms,cpu_ms,terrain,method,mode,eye_x,eye_y,eye_z,above_ground,yaw,"
          "pitch,"
          "fovy,cursor_x,"
          "cursor_y,ground_x,ground_y,ground_z,width,height,triangles,late_blocks,"
          "achieved_error_px\n";
  require_written();
}

void FlightLog::add(const Line& line) {
  constexpr double kNowhere = std::numeric_limits<double>::quiet_NaN();
  const glm::dvec3 ground = line.ground.value_or(glm::dvec3(kNowhere));
  const glm::dvec3 angles =
      glm::degrees(glm::dvec3(line.pose.yaw, line.pose.pitch, line.pose.fovy));
  out_ << fmt::format(
      "{},{:.4f},{:.3f},{:.3f},{},{},{},{:.4f},{:.4f},{:.4f},{:.4f},{:.6f},{:.6f},{:.4f},{:.1f},{:."
      "1f},{:."
      "4f},"
      "{:.4f},{:.4f},{},{},{},{},{:.4f}\n",
      frame_++, line.seconds, line.frame_ms, line.cpu_ms, line.terrain, line.method, line.mode,
      line.pose.eye.x, line.pose.eye.y, line.pose.eye.z, line.above_ground, angles.x, angles.y,
      angles.z, line.cursor.x, line.cursor.y, ground.x, ground.y, ground.z, line.width, line.height,
      line.triangles, line.late_blocks, line.achieved_error_px);
  require_written();
}

void FlightLog::require_written() {
  out_.flush();
  if (!out_) {
    throw Error(ErrorCode::Io, fmt::format("{}: cannot be written: {}: name another --trace",
                                           file_.string(), std::generic_category().message(errno)));
  }
}

}  // namespace arete::app
