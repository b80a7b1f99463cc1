#pragma once

#include <cstddef>
#include <iosfwd>
#include <string>

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

// Read from one word; the stream fails on anything else. CLI11 finds these by itself.
std::istream& operator>>(std::istream& in, Bytes& bytes);
std::istream& operator>>(std::istream& in, FrameSize& size);
std::istream& operator>>(std::istream& in, Tolerance& tolerance);

/// "3.2 MiB": for people.
std::string bytes_text(double bytes);
/// "1,234,567": for people.
std::string grouped(unsigned long long count);

}  // namespace arete::app
