#pragma once

#include <cstdint>
#include <vector>

#include "arete/lod/bintree/vertex_index.h"

namespace arete::lod::bintree {

/// Numbers by vertex: an open hash table that clears in no time and keeps its memory.
class IndexMap {
 public:
  /// The vertex's number; null when it has none. Holds until the next set or clear.
  const std::uint32_t* find(VertexIndex vertex) const {
    for (std::size_t i = start(vertex);; i = (i + 1) & mask_) {
      const Entry& e = entries_[i];
      if (e.stamp != stamp_) return nullptr;
      if (e.vertex == vertex) return &e.number;
    }
  }
  /// Requires: the vertex has no number.
  void set(VertexIndex vertex, std::uint32_t number) {
    if (2 * (size_ + 1) > entries_.size()) grow();
    place(vertex, number);
    ++size_;
  }
  void clear() {
    ++stamp_;
    size_ = 0;
  }
  std::size_t size() const { return size_; }

 private:
  struct Entry {
    VertexIndex vertex = 0;
    std::uint32_t number = 0, stamp = 0;
  };

  std::size_t start(VertexIndex vertex) const {
    return ((vertex * 0x9E3779B97F4A7C15U) >> 20U) & mask_;
  }
  void place(VertexIndex vertex, std::uint32_t number) {
    std::size_t i = start(vertex);
    while (entries_[i].stamp == stamp_) i = (i + 1) & mask_;
    entries_[i] = {vertex, number, stamp_};
  }
  void grow() {
    std::vector<Entry> old(entries_.size() * 2);
    old.swap(entries_);
    mask_ = entries_.size() - 1;
    for (const Entry& e : old) {
      if (e.stamp == stamp_) place(e.vertex, e.number);
    }
  }

  std::vector<Entry> entries_ = std::vector<Entry>(1024);
  std::size_t mask_ = 1023, size_ = 0;
  std::uint32_t stamp_ = 1;
};

}  // namespace arete::lod::bintree
