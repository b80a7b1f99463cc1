#include "json.h"

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

Json machine_json(const std::string& gl_renderer) {
  utsname system{};
  uname(&system);
  return {{"cpu", cpu_name()},
          {"threads", default_threads()},
          {"system", fmt::format("{} {}", system.sysname, system.machine)},
          {"gl_renderer", gl_renderer.empty() ? Json(nullptr) : Json(gl_renderer)}};
}

}  // namespace arete::app
