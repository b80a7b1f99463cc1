#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>

#include "arete/core/build_context.h"
#include "arete/core/height_source.h"
#include "arete/core/raster_source.h"
#include "arete/store/terrain.h"

namespace arete::store {

/// Takes the blocks of one unit of a segment.
class BlockSink {
 public:
  virtual ~BlockSink() = default;
  /// Compresses and keeps `raw` under `key`. Requires: keys ascend over the whole segment, unit by
  /// unit.
  virtual void add(std::uint64_t key, std::span<const std::byte> raw) = 0;
  using Visit = std::function<void(std::uint64_t key, std::span<const std::byte> raw)>;
  /// Visits the blocks with keys in [first, end) that `unit`, of an earlier phase, has added, in
  /// ascending order. Throws: Corrupt, Io.
  virtual void read_earlier(int unit, std::uint64_t first, std::uint64_t end,
                            const Visit& visit) const = 0;
};

/// A segment as units of work. Unit u's blocks must depend on `params`, u, what the store already
/// holds and units of earlier phases only: not on threads, time or other units, so that a killed
/// build resumes to the same bytes.
struct SegmentPlan {
  std::string name;    ///< lower case, digits, '-': the file is NAME.seg
  std::string params;  ///< everything that decides the content, as text
  int units = 0;
  std::function<void(int unit, BlockSink& sink)> make;  ///< called from several threads at once
  /// The first units of the second, third ... phase, ascending: a phase begins when the one before
  /// it is done. Empty: all units are independent.
  std::vector<int> later_phases = {};
  std::size_t unit_bytes = 0;  ///< memory of one make; as many run as fit half the memory limit
};

/// Where preprocess writes its segments.
class Writers {
 public:
  virtual ~Writers() = default;
  /// Makes all units in parallel (finished ones of an interrupted build are reused), then the
  /// segment. A segment already in the store with the same params is kept.
  virtual void write(const SegmentPlan& plan) = 0;
};

struct BuildOptions {
  std::filesystem::path output;  ///< NAME.arete
  bool force = false;            ///< rebuild although the store exists
  /// Everything that names the input: files, sizes, mtimes and options. Keys the resumable part
  /// directory only; never enters the store.
  std::string source_key;
  const RasterSource* drape = nullptr;  ///< pyramid to copy in, or none
  /// What the methods add; called once heights, mask, normals (and drape) are readable.
  std::function<void(const Terrain&, Writers&)> preprocess;
  std::vector<std::string> methods;  ///< names for the manifest
};

/// Builds a store from a DEM, or adds missing segments when the store at `output` is of the same
/// source. Publishes atomically: a crash leaves the old store or none, and the next call resumes.
/// The bytes depend on heights, options and methods only.
/// Throws: InvalidInput, Io, Limit, Cancelled; nothing is left at `output` then.
void build(HeightSource& source, const BuildOptions& options, const BuildContext& context);

/// Adds segments to an existing store (same atomic rules); used for methods chosen later.
void extend(const std::filesystem::path& store, const BuildOptions& options,
            const BuildContext& context);

}  // namespace arete::store
