#include "arete/store/terrain.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <thread>

#include <fmt/format.h>
#include <sys/stat.h>

#include "arete/core/error.h"
#include "arete/store/height_codec.h"
#include "arete/store/height_rows.h"
#include "arete/store/manifest.h"
#include "arete/store/part_directory.h"
#include "arete/store/raster_pyramid.h"
#include "arete/store/raster_recipe.h"
#include "arete/store/terrain_impl.h"

namespace arete::store {
namespace {

constexpr std::string_view kHeights = "heights";
// A tile with validity: the largest there is.
constexpr std::size_t kDecodedTileBytes =
    sizeof(HeightTile) + kTilePostCount * (sizeof(std::int32_t) + 1);
constexpr std::uint64_t kMaxManifestBytes = std::uint64_t{16} << 20U;

std::string read_text(const File& file, const std::string& name) {
  if (file.size() > kMaxManifestBytes)
    throw Error(ErrorCode::Corrupt, name + ": too large for a manifest: rebuild the store");
  std::string text(file.size(), '\0');
  file.read_at(0, std::as_writable_bytes(std::span(text)));
  return text;
}

std::size_t bytes_of(const HeightTile& tile) {
  return sizeof(HeightTile) + tile.counts.capacity() * sizeof(std::int32_t) + tile.valid.capacity();
}

using DirectoryIdentity = std::array<std::uint64_t, 2>;

// Zeros when there is none.
DirectoryIdentity identity_of(const std::filesystem::path& directory) {
  struct stat status {};
  if (::stat(directory.c_str(), &status) != 0) return {};
  return {status.st_dev, status.st_ino};
}

// Readers change nothing, so they only say where the store is.
void require_not_retired(const std::filesystem::path& store) {
  if (const auto retired = retired_store(store))
    throw Error(ErrorCode::NotFound,
                fmt::format("{}: not there: its replacement is at work, or broke off and left it "
                            "in {}: open it again, or build again, which brings it back",
                            store.string(), retired->string()));
}

// A store that was exchanged twice meanwhile looks as it did: a failure counts the third time. A
// replacement that is at work between its two renames is given 0.1 s.
constexpr int kTries = 3, kTriesOfRetired = 20;
constexpr std::chrono::milliseconds kPause{5};

// Level 0 from the heights, the other levels from the segment.
class DerivedRaster : public RasterSource {
 public:
  DerivedRaster(const Terrain& terrain, RasterRecipe recipe, std::unique_ptr<RasterSource> stored)
      : terrain_(terrain), recipe_(std::move(recipe)), stored_(std::move(stored)) {}

  RasterShape shape() const override { return recipe_.shape; }

  Texels read(TileId id) const override {
    if (id.level > 0) return stored_->read(id);
    std::shared_ptr<const HeightTile> held;
    const TileReader read = [&](TileId tile) {
      held = terrain_.heights(tile, Fetch::Wait);
      return held.get();
    };
    Texels texels = filled_tile(recipe_.shape);
    const Manifest& m = terrain_.manifest();
    make_level0(recipe_, {m.cols, m.rows}, id, read, texels);
    return texels;
  }

 private:
  const Terrain& terrain_;
  RasterRecipe recipe_;
  std::unique_ptr<RasterSource> stored_;
};

}  // namespace

Terrain::Impl::Impl(std::filesystem::path path, OpenOptions open_options)
    : store(std::move(path)),
      known_as(store.string()),
      options(std::move(open_options)),
      cache(options.cache_bytes) {
  const std::filesystem::path file = store / kManifestName;
  manifest = parse_manifest(read_text(*open(file), file.string()), file.string());
  shape = {manifest.cols, manifest.rows};
  levels = shape.levels();
  for (const SegmentRecord& record : manifest.segments) add_segment(record);
  if (heights_segment < 0)
    throw Error(ErrorCode::Corrupt, store.string() + ": has no heights: rebuild the store");
  if (options.prefetch)
    prefetcher = std::make_unique<Prefetcher>([this](const BlockName& name) {
      if (!cache.contains(name) && !known_damaged(name)) load(name);
    });
}

std::unique_ptr<File> Terrain::Impl::open(const std::filesystem::path& path) const {
  return options.open ? options.open(path) : open_file(path);
}

void Terrain::Impl::add_segment(const SegmentRecord& record) {
  const std::filesystem::path file = store / (record.name + ".seg");
  auto reader = std::make_unique<SegmentReader>(open(file), file.string());
  if (reader->name() != record.name || reader->id() != record.id)
    throw Error(ErrorCode::Corrupt,
                file.string() + ": not the segment that the manifest names: rebuild the store");
  segments.push_back(std::move(reader));
  if (record.name == kHeights) heights_segment = static_cast<int>(segments.size()) - 1;
}

int Terrain::Impl::find_segment(std::string_view name) const {
  for (std::size_t i = segments.size(); i-- > 0;)
    if (segments[i]->name() == name) return static_cast<int>(i);
  return -1;
}

const SegmentReader& Terrain::Impl::segment(std::string_view name) const {
  const int i = find_segment(name);
  if (i < 0)
    throw Error(
        ErrorCode::NotFound,
        fmt::format("{}: has no segment \"{}\": build it with that method", store.string(), name));
  return *segments[static_cast<std::size_t>(i)];
}

std::shared_ptr<const void> Terrain::Impl::fetch(const BlockName& name, Fetch how) {
  if (auto block = cache.find(name)) {
    ++hits;
    return block;
  }
  if (how == Fetch::Held) return nullptr;
  if (!segments[name.segment]->contains(name.key) || known_damaged(name)) return nullptr;
  if (how == Fetch::Wait) {
    ++misses;
    return load(name);
  }
  ++late;
  if (prefetcher) prefetcher->add_missed(name);
  return nullptr;
}

std::shared_ptr<const void> Terrain::Impl::load(const BlockName& name) {
  try {
    std::vector<std::byte> raw;
    const std::size_t read = segments[name.segment]->read(name.key, raw);
    if (read == 0) return nullptr;
    bytes_read += read;
    if (static_cast<int>(name.segment) == heights_segment) {
      auto tile = std::make_shared<HeightTile>();
      decode_tile(raw, *tile);
      return cache.insert(name, tile, bytes_of(*tile));
    }
    const std::size_t bytes = sizeof raw + raw.size();
    return cache.insert(name, std::make_shared<const std::vector<std::byte>>(std::move(raw)),
                        bytes);
  } catch (const std::exception&) {
    note_damage(name);
    return nullptr;
  }
}

void Terrain::Impl::note_damage(const BlockName& name) {
  const std::scoped_lock lock(damaged_mutex);
  if (damaged_blocks.insert(name).second) ++damaged;
}

bool Terrain::Impl::known_damaged(const BlockName& name) {
  if (damaged == 0) return false;
  const std::scoped_lock lock(damaged_mutex);
  return damaged_blocks.contains(name);
}

Terrain::Terrain() = default;
Terrain::~Terrain() = default;

// While a new store takes an old one's place, names may lead to files of both: then the one that is
// there now is opened.
std::unique_ptr<Terrain> Terrain::open(const std::filesystem::path& store, OpenOptions options) {
  std::unique_ptr<Terrain> terrain(new Terrain());
  for (int failures = 0; true;) {
    const DirectoryIdentity before = identity_of(store);
    try {
      terrain->impl_ = std::make_unique<Impl>(store, options);
      return terrain;
    } catch (const Error&) {
      const bool is_retired = retired_store(store).has_value();
      // Asked last: a store that has come back before the other question is another one now.
      if (identity_of(store) != before) continue;
      if (++failures < (is_retired ? kTriesOfRetired : kTries)) {
        if (is_retired) std::this_thread::sleep_for(kPause);
        continue;
      }
      require_not_retired(store);
      throw;
    }
  }
}

const Manifest& Terrain::manifest() const {
  return impl_->manifest;
}
std::string Terrain::name() const {
  return impl_->known_as;
}
int Terrain::levels() const {
  return impl_->levels;
}
int Terrain::tiles_x(int level) const {
  return impl_->shape.tiles_x(level);
}
int Terrain::tiles_y(int level) const {
  return impl_->shape.tiles_y(level);
}

std::shared_ptr<const HeightTile> Terrain::heights(TileId id, Fetch fetch) const {
  if (!impl_->shape.contains(id)) return nullptr;
  const auto segment = static_cast<std::uint32_t>(impl_->heights_segment);
  return std::static_pointer_cast<const HeightTile>(impl_->fetch({segment, id.key()}, fetch));
}

double Terrain::z_of(std::int32_t count) const {
  return impl_->manifest.offset_m + impl_->manifest.quantum_m * count;
}

bool Terrain::has_segment(std::string_view name) const {
  return impl_->find_segment(name) >= 0;
}

std::string Terrain::segment_params(std::string_view name) const {
  return impl_->segment(name).params();
}

std::span<const std::uint64_t> Terrain::keys(std::string_view name) const {
  return impl_->segment(name).keys();
}

std::shared_ptr<const std::vector<std::byte>> Terrain::block(std::string_view segment,
                                                             std::uint64_t key, Fetch fetch) const {
  const int i = impl_->find_segment(segment);
  if (i < 0 || i == impl_->heights_segment) return nullptr;
  return std::static_pointer_cast<const std::vector<std::byte>>(
      impl_->fetch({static_cast<std::uint32_t>(i), key}, fetch));
}

std::size_t Terrain::read_block(std::string_view segment, std::uint64_t key,
                                std::vector<std::byte>& raw) const {
  const SegmentReader& reader = impl_->segment(segment);
  try {
    return reader.read(key, raw);
  } catch (const Error&) {
    impl_->note_damage({static_cast<std::uint32_t>(impl_->find_segment(segment)), key});
    throw;
  }
}

std::unique_ptr<HeightSource> Terrain::height_source() const {
  return make_height_rows(impl_->segment(kHeights), impl_->manifest);
}

std::unique_ptr<RasterSource> Terrain::raster(std::string_view segment) const {
  if (!has_segment(segment)) return nullptr;
  auto stored = open_raster(impl_->segment(segment), &impl_->damaged);
  const Manifest& m = impl_->manifest;
  std::optional<RasterRecipe> recipe;
  if (segment == "mask") recipe = mask_recipe(impl_->shape);
  if (segment == "normals")
    recipe = normals_recipe(impl_->shape, m.georef.world_from_post, m.quantum_m);
  if (!recipe) return stored;
  return std::make_unique<DerivedRaster>(*this, std::move(*recipe), std::move(stored));
}

void Terrain::prefetch(std::span<const TileId> tiles) const {
  if (!impl_->prefetcher) return;
  const auto segment = static_cast<std::uint32_t>(impl_->heights_segment);
  // Asking for more than the cache holds would let the least wanted push out the most wanted.
  const std::size_t fit = impl_->options.cache_bytes / kDecodedTileBytes;
  std::vector<BlockName> wanted;
  wanted.reserve(std::min(tiles.size(), fit));
  for (const TileId id : tiles)
    if (wanted.size() < fit && impl_->shape.contains(id)) wanted.push_back({segment, id.key()});
  impl_->prefetcher->replace(std::move(wanted));
}

CacheStats Terrain::cache_stats() const {
  CacheStats stats;
  stats.resident_bytes = impl_->cache.resident_bytes();
  stats.resident_bytes_max = impl_->cache.resident_bytes_max();
  stats.hits = impl_->hits;
  stats.misses = impl_->misses;
  stats.late = impl_->late;
  stats.bytes_read = impl_->bytes_read;
  stats.damaged = impl_->damaged;
  return stats;
}

std::uint64_t Terrain::table_bytes() const {
  constexpr std::uint64_t kThreads = 2;
  constexpr std::uint64_t kCopies = 3;  // pages as read, counts as stored, the tile
  std::uint64_t bytes = kThreads * kCopies * kDecodedTileBytes;
  for (const auto& segment : impl_->segments) bytes += segment->table_bytes();
  return bytes;
}

void Terrain::drop_os_cache() const {
  for (const auto& segment : impl_->segments) segment->drop_os_cache();
}

std::uint64_t Terrain::check_all(const std::function<void(double)>& progress) const {
  std::uint64_t total = 0;
  for (const auto& segment : impl_->segments) total += segment->page_count();
  std::uint64_t before = 0;
  const auto report = [&](std::uint64_t pages) {
    if (progress) progress(static_cast<double>(before + pages) / static_cast<double>(total));
  };
  for (const auto& segment : impl_->segments) {
    segment->check_all(report);
    before += segment->page_count();
    report(0);
  }
  return total;
}

}  // namespace arete::store
