#include "torture/samples.h"

#include <cstring>
#include <span>

#include "arete/core/error.h"
#include "arete/core/raster_source.h"
#include "arete/lod/engine.h"
#include "arete/store/hash.h"
#include "arete/store/manifest.h"

#include "store/store_fixture.h"

namespace arete::torture {
namespace {

using store::Fetch;
using store::Terrain;

constexpr int kCols = 140, kRows = 70;

class SharedFile : public store::File {
 public:
  explicit SharedFile(const Bytes& bytes) : bytes_(bytes) {}
  std::uint64_t size() const override { return bytes_.size(); }
  void read_at(std::uint64_t offset, std::span<std::byte> out) const override {
    if (offset > bytes_.size() || out.size() > bytes_.size() - offset)
      throw Error(ErrorCode::Corrupt, "memory: the file ends");
    if (!out.empty()) std::memcpy(out.data(), bytes_.data() + offset, out.size());
  }

 private:
  const Bytes& bytes_;
};

template <typename T>
std::uint64_t hash_of(const std::vector<T>& values) {
  return store::hash64(std::as_bytes(std::span(values)));
}

void read_heights(const Terrain& terrain, Content& content) {
  for (const std::uint64_t key : terrain.keys("heights"))
    if (const auto tile = terrain.heights(TileId::from_key(key), Fetch::Wait))
      content["heights " + std::to_string(key)] = hash_of(tile->counts) ^ hash_of(tile->valid);
}

void read_blocks(const Terrain& terrain, const std::string& segment, Content& content) {
  for (const std::uint64_t key : terrain.keys(segment))
    if (const auto block = terrain.block(segment, key, Fetch::Wait))
      content[segment + " " + std::to_string(key)] = hash_of(*block);
}

// Of a raster, tiles of one level; those met damaged are reported by a count, not one by one.
void read_level(const Terrain& terrain, const std::string& name, int level, Content& content) {
  const auto raster = terrain.raster(name);
  if (!raster) return;
  const RasterShape shape = raster->shape();
  const auto tiles = [&](int texels) {
    return static_cast<std::uint32_t>((texels >> level) / shape.tile_size) + 1;
  };
  for (std::uint32_t y = 0; y < tiles(shape.height); ++y)
    for (std::uint32_t x = 0; x < tiles(shape.width); ++x) {
      const TileId id{static_cast<std::uint32_t>(level), x, y};
      content[name + " texels " + std::to_string(id.key())] = hash_of(raster->read(id).bytes);
    }
}

bool is_raster(const std::string& segment) {
  return segment == "normals" || segment == "mask" || segment == "drape";
}

void read_rows(const Terrain& terrain, Content& content) {
  const auto rows = terrain.height_source();
  std::vector<float> row(static_cast<std::size_t>(rows->cols()));
  for (int r = 0; r < rows->rows(); ++r) {
    try {
      rows->read_row(r, row);
      content["row " + std::to_string(r)] = hash_of(row);
    } catch (const Error&) {
      continue;
    }
  }
}

void read_pictures(const Terrain& terrain, Content& content) {
  const View view = make_view({.eye = {60, -90, 1200}, .pitch = -0.9, .near_m = 1}, 320, 240);
  for (const lod::EngineInfo& info : lod::engines()) {
    DrawList list;
    try {
      info.open(terrain, {})->refine(view, {}, list);
    } catch (const Error&) {
      continue;
    }
    std::uint64_t sum = list.batches.size();
    for (const DrawBatch& batch : list.batches) sum = sum * 31 + batch.index_count;
    content["picture " + std::string(info.name)] = sum;
  }
}

}  // namespace

void build_sample(const std::filesystem::path& output, std::uint32_t seed) {
  Heightfield field = store::make_hills(kCols, kRows, seed);
  store::punch_holes(field, 2, 9);
  store::BuildOptions options;
  options.output = output;
  options.source_key = std::to_string(seed);
  options.force = true;
  const BuildContext context{.threads = 1, .progress = {}};
  options.preprocess = [&](const Terrain& terrain, store::Writers& writers) {
    for (const lod::EngineInfo& info : lod::engines())
      info.preprocess(terrain, writers, context, {});
  };
  store::build(field, options, context);
}

Files sample_store(std::uint32_t seed) {
  const store::TemporaryFolder folder;
  build_sample(folder / "t.arete", seed);
  return store::read_all_files(folder / "t.arete");
}

void extend_sample(const std::filesystem::path& store) {
  store::BuildOptions options;
  options.source_key = "extend";
  options.methods = {"added"};
  options.preprocess = [](const Terrain&, store::Writers& writers) {
    store::SegmentPlan plan{.name = "added", .params = "p", .units = 2, .make = {}};
    plan.make = [](int unit, store::BlockSink& sink) {
      const std::vector<int> values(3000, unit);
      sink.add(static_cast<std::uint64_t>(unit), std::as_bytes(std::span(values)));
    };
    writers.write(plan);
  };
  store::extend(store, options, {.threads = 1, .progress = {}});
}

std::unique_ptr<Terrain> open_in_memory(const Files& files) {
  store::OpenOptions options;
  options.prefetch = false;
  options.open = [&files](const std::filesystem::path& path) {
    const auto file = files.find(path.filename().string());
    if (file == files.end()) throw Error(ErrorCode::NotFound, path.string() + ": not there");
    return std::make_unique<SharedFile>(file->second);
  };
  return Terrain::open("/nonexistent/memory.arete", options);
}

Content read_segment(const Terrain& terrain, const std::string& segment) {
  Content content;
  if (segment == "heights")
    read_heights(terrain, content);
  else
    read_blocks(terrain, segment, content);
  if (is_raster(segment))
    for (int level = 1; level < terrain.raster(segment)->shape().levels; ++level)
      read_level(terrain, segment, level, content);
  return content;
}

Content read_everything(const Terrain& terrain) {
  Content content;
  for (const store::SegmentRecord& record : terrain.manifest().segments)
    content.merge(read_segment(terrain, record.name));
  content["manifest"] = store::hash64(store::to_text(terrain.manifest()));
  read_level(terrain, "normals", 0, content);
  read_level(terrain, "mask", 0, content);
  read_rows(terrain, content);
  read_pictures(terrain, content);
  return content;
}

Harm compare(const Content& got, const Content& intact, const Terrain& terrain) {
  const bool reported = terrain.cache_stats().damaged > 0;
  Harm harm = got.size() < intact.size() || reported ? Harm::Detected : Harm::None;
  for (const auto& [name, hash] : got) {
    const auto was = intact.find(name);
    const bool same = was != intact.end() && was->second == hash;
    // What is put together from several blocks may differ once one of them is known to be damaged.
    const bool is_made = name.find("texels") != std::string::npos || name.starts_with("picture");
    if (!same && !(is_made && reported)) return Harm::Silent;
  }
  return harm;
}

}  // namespace arete::torture
