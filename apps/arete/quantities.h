#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace arete::app {

/// A number of bytes as people write it: "512M", "1G", "1.5GiB", "4096". K, M, G and T are powers
/// of 1024.
struct Bytes {
  std::size_t count = 0;
};

/// "1280x720"; both sides in [1, 16384].
struct FrameSize {
  int width = 1280, height = 720;
};

/// A screen error: "1", "0.5" in pixels, or "0.2%" of the viewport's height.
struct Tolerance {
  double value = 1;
  bool percent = false;
  double pixels(int viewport_height) const;
};

/// Reads the whole text; false, with the quantity as it was, when it is anything else.
bool parse(std::string_view text, Bytes& bytes);
bool parse(std::string_view text, FrameSize& size);
bool parse(std::string_view text, Tolerance& tolerance);

/// "3.2 MiB": for people.
std::string bytes_text(double bytes);
/// "1,234,567": for people.
std::string grouped(unsigned long long count);

}  // namespace arete::app
