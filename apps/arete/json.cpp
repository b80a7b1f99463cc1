#include "json.h"

#include <cmath>
#include <cstdio>
#include <fstream>
#include <string>

#include <fmt/format.h>
#include <sys/utsname.h>

#include "arete/core/parallel.h"

namespace arete::app {
namespace {

std::string cpu_name() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("model name")) {
      return line.substr(std::min(line.find(':') + 2, line.size()));
    }
  }
  return "unknown";
}

}  // namespace

void print_json(const Json& json) {
  fmt::print("{}\n", json.dump(2, ' ', false, Json::error_handler_t::replace));
}

Json finite(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

Json options_json(const FlightFlags& flags, const std::string& method) {
  const bool capped = flags.triangles != lod::Budget::kUnlimited;
  Json settings = Json::object();
  for (const auto& [name, value] : params_of(flags.terrain.method_flags, method)) {
    settings[name] = value;
  }
  return {{"path", flags.path},
          {"width", flags.size.width},
          {"height", flags.size.height},
          {"tolerance_px", flags.refine_options().tolerance_px},
          {"scale", flags.scale},
          {"cache_bytes", flags.terrain.cache.count},
          {"gpu_memory_bytes", flags.gpu_memory.count},
          {"triangles", capped ? Json(flags.triangles) : Json(nullptr)},
          {"settings", settings}};
}

Json machine_json(const std::string& gl_renderer) {
  utsname system{};
  uname(&system);
  return {{"cpu", cpu_name()},
          {"threads", default_threads()},
          {"system", fmt::format("{} {}", system.sysname, system.machine)},
          {"gl_renderer", gl_renderer.empty() ? Json(nullptr) : Json(gl_renderer)}};
}

}  // namespace arete::app
