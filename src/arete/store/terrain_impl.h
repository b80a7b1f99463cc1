#pragma once

#include <atomic>
#include <filesystem>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "arete/store/cache.h"
#include "arete/store/prefetcher.h"
#include "arete/store/pyramid_shape.h"
#include "arete/store/segment_reader.h"
#include "arete/store/terrain.h"

namespace arete::store {

struct Terrain::Impl {
  Impl(std::filesystem::path store, OpenOptions open_options);

  /// Opens the segment's file and adds it; from then on it stands for an older one of its name,
  /// whose cached blocks are of no more use. Not while other threads use the terrain.
  /// Throws: Corrupt when it is not the recorded segment.
  void add_segment(const SegmentRecord& record);
  /// Index into `segments`, or -1.
  int find_segment(std::string_view name) const;
  const SegmentReader& segment(std::string_view name) const;  ///< Throws: NotFound

  /// The cached block, else (Wait) reads it. Null: absent, damaged, or not here under Resident.
  std::shared_ptr<const void> fetch(const BlockName& name, Fetch how);
  /// Reads, verifies, decodes and caches. Null when absent or damaged. Throws nothing.
  std::shared_ptr<const void> load(const BlockName& name);
  /// Counts a block once, however often it is read.
  void note_damage(const BlockName& name);
  bool known_damaged(const BlockName& name);
  std::unique_ptr<File> open(const std::filesystem::path& path) const;

  std::filesystem::path store;
  std::string known_as;  ///< what messages call it
  OpenOptions options;
  Manifest manifest;
  PyramidShape shape;
  int levels = 1;
  std::vector<std::unique_ptr<SegmentReader>> segments;
  int heights_segment = -1;
  BlockCache cache;
  std::atomic<std::uint64_t> hits{0}, misses{0}, late{0}, bytes_read{0}, damaged{0};
  std::mutex damaged_mutex;
  BlockSet damaged_blocks;                 ///< not read again: the file will not mend itself
  std::unique_ptr<Prefetcher> prefetcher;  ///< last: it stops before what it uses goes
};

}  // namespace arete::store
