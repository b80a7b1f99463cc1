#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace arete::lod::bintree {

/// A frame's triangles, made of new ones and of stretches of the frame before. Stretches that
/// follow each other in both are copied at once.
class IndexList {
 public:
  void begin() {
    before_.swap(now_);
    now_.clear();
    copied_from_ = copied_to_ = 0;
  }
  void triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    flush();
    now_.insert(now_.end(), {a, b, c});
  }
  /// Indices [from, from + count) of the frame before.
  void copy(std::uint32_t from, std::uint32_t count) {
    if (from != copied_to_) {
      flush();
      copied_from_ = from;
    }
    copied_to_ = from + count;
  }
  void end() { flush(); }
  /// Of the frame. Requires: end().
  std::span<const std::uint32_t> all() const { return now_; }

 private:
  void flush() {
    if (copied_from_ == copied_to_) return;
    now_.insert(now_.end(), before_.begin() + copied_from_, before_.begin() + copied_to_);
    copied_from_ = copied_to_;
  }

  std::vector<std::uint32_t> now_, before_;
  std::uint32_t copied_from_ = 0, copied_to_ = 0;
};

}  // namespace arete::lod::bintree
