#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "arete/core/georef.h"
#include "arete/core/height_source.h"
#include "arete/core/raster_source.h"
#include "arete/core/tile_id.h"
#include "arete/store/file.h"

namespace arete::store {

/// Cells a side of a stored height tile; it has kTilePosts = 129 posts a side, borders shared.
inline constexpr int kTileCells = 128;
inline constexpr int kTilePosts = kTileCells + 1;

/// One decoded square of heights at spacing 2^level. Posts beyond the grid repeat the edge post and
/// are invalid.
struct HeightTile {
  std::vector<std::int32_t>
      counts;  ///< kTilePosts^2, row-major, NW first; z = offset + quantum * count
  std::vector<std::uint8_t> valid;  ///< 1 = data, 0 = filled; empty when every post has data
  bool is_valid(int col, int row) const {
    return valid.empty() ||
           valid[static_cast<std::size_t>(row) * kTilePosts + static_cast<std::size_t>(col)] != 0;
  }
};

struct SegmentRecord {
  std::string name;  ///< "heights", "mask", "normals", "drape", "tables-65", ...
  std::string id;    ///< 32 hex digits: hash of parameters and content
  std::uint64_t bytes = 0;
};

/// What manifest.json says. See docs/format.md.
struct Manifest {
  int format_version = 1;
  std::string id;
  int cols = 0, rows = 0;
  Georef georef;
  double z_min = 0, z_max = 0;  ///< metres, over valid posts; 0 when there are none
  double quantum_m = 0, offset_m = 0;
  double max_store_error_m = 0;  ///< largest |stored - source| over valid posts
  double nodata_share = 0;       ///< invalid posts / all posts
  std::uint64_t drawable_cells = 0;
  std::string source;  ///< HeightSource::description()
  std::vector<std::string> methods;
  std::vector<SegmentRecord> segments;
};

struct CacheStats {
  std::uint64_t resident_bytes = 0, resident_bytes_max = 0;
  std::uint64_t hits = 0, misses = 0;
  std::uint64_t late = 0;        ///< Resident requests that were not there
  std::uint64_t bytes_read = 0;  ///< from files
  std::uint64_t damaged = 0;     ///< blocks that failed verification, each once
};

/// Wait reads and verifies on the caller's thread; Resident returns only what is in memory and
/// asks the prefetch thread for the rest; Held does not even ask.
enum class Fetch { Wait, Resident, Held };

struct OpenOptions {
  std::size_t cache_bytes = std::size_t{512} << 20U;  ///< hard cap on decoded blocks held
  bool prefetch = true;                               ///< run the prefetch thread
  /// The seam for tests: how files are opened. Empty = open_file.
  std::function<std::unique_ptr<File>(const std::filesystem::path&)> open;
};

/// An opened store: directory + verified block cache + prefetch.
/// Thread contract: every const member may be called from several threads at once.
class Terrain {
 public:
  /// Checks the manifest, every segment's header, directory and footer. Of a store that is being
  /// replaced the old or the new one is opened.
  /// Throws: NotFound, Corrupt, Unsupported, each naming file, cause and remedy.
  static std::unique_ptr<Terrain> open(const std::filesystem::path& store,
                                       OpenOptions options = {});
  ~Terrain();
  Terrain(const Terrain&) = delete;
  Terrain& operator=(const Terrain&) = delete;

  const Manifest& manifest() const;
  /// What messages call it: its path; while it is being built, the path that it will have.
  std::string name() const;
  /// Height pyramid: levels 0..levels()-1; the coarsest is one tile.
  int levels() const;
  /// Tiles along x and y at a level.
  int tiles_x(int level) const;
  int tiles_y(int level) const;

  /// A height tile; null when it is missing, damaged or (Resident, Held) not here. A tile outside
  /// the pyramid is null. Not stored are level-0 tiles without a drawable cell and coarser ones
  /// without a valid post. Throws: nothing.
  std::shared_ptr<const HeightTile> heights(TileId id, Fetch fetch) const;
  double z_of(std::int32_t count) const;

  bool has_segment(std::string_view name) const;
  /// The parameter string that the segment was written with. Throws: NotFound.
  std::string segment_params(std::string_view name) const;
  /// Keys of a segment, ascending. Throws: NotFound.
  std::span<const std::uint64_t> keys(std::string_view name) const;
  /// The decoded bytes of a block, through the cache. Null when absent or damaged. Throws: nothing.
  std::shared_ptr<const std::vector<std::byte>> block(std::string_view segment, std::uint64_t key,
                                                      Fetch fetch) const;

  /// Reads and verifies a block anew, past the cache: for who keeps blocks in another form. Returns
  /// the bytes read from the file; 0 when there is no such block. One that fails counts as damaged.
  /// Throws: NotFound, Corrupt, Io.
  std::size_t read_block(std::string_view segment, std::uint64_t key,
                         std::vector<std::byte>& raw) const;

  /// Fresh rows of the stored heights, decoded anew without the cache; NaN = no data. Lives as long
  /// as the Terrain. Its read_row throws Corrupt where a tile is damaged.
  std::unique_ptr<HeightSource> height_source() const;
  /// The pyramid "normals", "mask" or "drape"; null when the store has none. Level 0 of normals and
  /// mask is made from the heights when read. Lives as long as the Terrain.
  std::unique_ptr<RasterSource> raster(std::string_view segment) const;

  /// Asks the prefetch thread for tiles, most wanted first; replaces what was asked before. As many
  /// as the cache holds are taken.
  void prefetch(std::span<const TileId> tiles) const;
  CacheStats cache_stats() const;
  /// Memory beside the cache: the segments' directories, and what the caller's and the prefetch
  /// thread have in hand while they read a tile each.
  std::uint64_t table_bytes() const;

  /// Asks the system to forget what it holds of the segments' files (File::drop_os_cache); what
  /// this Terrain's own cache holds stays.
  void drop_os_cache() const;

  /// Reads and verifies every page of every segment. Returns the number of pages.
  /// Throws: Corrupt at the first bad page, naming segment and page.
  std::uint64_t check_all(const std::function<void(double done)>& progress = {}) const;

 private:
  friend class StoreBuilder;  // adds segments while a store is being built
  Terrain();
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace arete::store
