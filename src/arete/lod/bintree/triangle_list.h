#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace arete::lod::bintree {

/// The triangles drawn, each at a place of its own until it goes: a frame changes what has changed.
class TriangleList {
 public:
  using Triangle = std::array<std::uint32_t, 3>;

  void reserve(std::size_t triangles) {
    indices_.reserve(3 * triangles);
    owners_.reserve(triangles);
  }
  /// A new place, to be set.
  std::uint32_t add() {
    owners_.push_back(0);
    indices_.resize(indices_.size() + 3);
    return static_cast<std::uint32_t>(owners_.size()) - 1;
  }
  void set(std::uint32_t place, std::uint32_t owner, const Triangle& t) {
    owners_[place] = owner;
    std::copy(t.begin(), t.end(), indices_.begin() + 3 * static_cast<std::ptrdiff_t>(place));
  }
  /// The last triangle takes the place; returns its owner. Requires: not empty.
  std::uint32_t remove(std::uint32_t place) {
    const std::uint32_t owner = owners_.back();
    const auto last = indices_.end() - 3;
    set(place, owner, {last[0], last[1], last[2]});
    owners_.pop_back();
    indices_.resize(indices_.size() - 3);
    return owner;
  }
  void clear() {
    indices_.clear();
    owners_.clear();
  }
  std::size_t size() const { return owners_.size(); }
  std::span<const std::uint32_t> indices() const { return indices_; }

 private:
  std::vector<std::uint32_t> indices_, owners_;
};

}  // namespace arete::lod::bintree
