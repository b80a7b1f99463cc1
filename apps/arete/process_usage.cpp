#include "process_usage.h"

#include <fstream>
#include <string>

#include <sys/resource.h>

namespace arete::app {

std::uint64_t major_page_faults() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::uint64_t>(usage.ru_majflt);
}

std::uint64_t peak_rss_bytes() {
  std::ifstream status("/proc/self/status");
  for (std::string key; status >> key;) {
    if (std::uint64_t kib = 0; key == "VmHWM:" && status >> kib) {
      return kib * 1024;
    }
    status.ignore(1 << 16, '\n');
  }
  return 0;
}

void reset_peak_rss() {
  std::ofstream("/proc/self/clear_refs") << "5";
}

}  // namespace arete::app
