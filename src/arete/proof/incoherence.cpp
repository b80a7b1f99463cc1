#include "arete/proof/incoherence.h"

#include <algorithm>
#include <array>
#include <iterator>

namespace arete::proof {
namespace {

std::uint64_t post_key(Post p) {
  return (static_cast<std::uint64_t>(static_cast<std::uint32_t>(p.row)) << 32U) |
         static_cast<std::uint32_t>(p.col);
}

// Finaliser of splitmix64; folds three sorted posts into one key. Two triangles of a frame share a
// key with a chance of about n^2 / 2^65.
std::uint64_t mix(std::uint64_t x) {
  x = (x ^ (x >> 30U)) * 0xbf58476d1ce4e5b9U;
  x = (x ^ (x >> 27U)) * 0x94d049bb133111ebU;
  return x ^ (x >> 31U);
}

std::uint64_t triangle_key(std::array<std::uint64_t, 3> posts) {
  std::ranges::sort(posts);
  return mix(mix(mix(posts[0]) + posts[1]) + posts[2]);
}

std::size_t count_differences(const std::vector<std::uint64_t>& a,
                              const std::vector<std::uint64_t>& b) {
  std::size_t common = 0;
  for (auto i = a.begin(), j = b.begin(); i != a.end() && j != b.end();) {
    if (*i == *j) {
      ++common, ++i, ++j;
    } else if (*i < *j) {
      ++i;
    } else {
      ++j;
    }
  }
  return a.size() + b.size() - 2 * common;
}

}  // namespace

double Incoherence::add(const DrawList& list, const BlockSource& blocks) {
  mesh::flatten(list, blocks, surface_);
  now_.clear();
  const auto key = [&](std::size_t i) {
    return post_key(surface_.vertices[surface_.indices[i]].post);
  };
  for (std::size_t i = 0; i + 2 < surface_.indices.size(); i += 3) {
    now_.push_back(triangle_key({key(i), key(i + 1), key(i + 2)}));
  }
  std::ranges::sort(now_);
  double changed = 0;
  if (!first_ && !now_.empty()) {
    changed =
        static_cast<double>(count_differences(now_, before_)) / static_cast<double>(now_.size());
    sum_ += changed;
    ++pairs_;
  }
  first_ = false;
  std::swap(now_, before_);
  return 100 * changed;
}

}  // namespace arete::proof
