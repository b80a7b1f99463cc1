#pragma once

#include <cstdint>

namespace arete::app {

/// Page faults of this process so far that had to read from a device.
std::uint64_t major_page_faults();
/// Bytes of memory that this process held at most since the last reset (Linux: VmHWM).
std::uint64_t peak_rss_bytes();
/// Starts the peak anew where the system allows it; else the peak is that of the whole process.
void reset_peak_rss();

}  // namespace arete::app
