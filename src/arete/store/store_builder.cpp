#include "arete/store/store_builder.h"

#include <algorithm>
#include <cassert>
#include <set>

#include "arete/core/error.h"
#include "arete/store/manifest.h"
#include "arete/store/output_file.h"
#include "arete/store/segment_writer.h"
#include "arete/store/terrain_impl.h"
#include "arete/store/work.h"

namespace arete::store {
namespace {

namespace fs = std::filesystem;

std::vector<BlockEntry> all_entries(const std::vector<UnitRef>& units) {
  std::vector<BlockEntry> entries;
  for (const UnitRef& ref : units) {
    const auto unit = ref.open();
    entries.insert(entries.end(), unit->entries().begin(), unit->entries().end());
  }
  assert(std::ranges::is_sorted(entries, {}, &BlockEntry::key));
  return entries;
}

// A unit that is being made, with a view of the finished ones.
class UnitSink : public BlockSink {
 public:
  UnitSink(UnitWriter& unit, const UnitFolder& folder) : unit_(unit), folder_(folder) {}

  void add(std::uint64_t key, std::span<const std::byte> raw) override { unit_.add(key, raw); }

  void read_earlier(int unit, std::uint64_t first, std::uint64_t end,
                    const Visit& visit) const override {
    const auto reader = folder_.open(unit);
    const auto entries = reader->entries();
    std::vector<std::byte> raw;
    auto entry = std::ranges::lower_bound(entries, first, {}, &BlockEntry::key);
    for (; entry != entries.end() && entry->key < end; ++entry) {
      reader->read(entry->key, raw);
      visit(entry->key, raw);
    }
  }

 private:
  UnitWriter& unit_;
  const UnitFolder& folder_;
};

}  // namespace

StoreBuilder::StoreBuilder(const PartDirectory& part, const BuildContext& context)
    : units_(part.units()), store_(part.store()), output_(part.output()), context_(context) {}

fs::path StoreBuilder::file_of(const std::string& name) const {
  return store_ / (name + ".seg");
}

std::unique_ptr<SegmentReader> StoreBuilder::open_segment(const std::string& name) const {
  return std::make_unique<SegmentReader>(open_file(file_of(name)), file_of(name).string());
}

void StoreBuilder::adopt(const fs::path& store, const Manifest& published) {
  manifest = published;
  for (const SegmentRecord& segment : manifest.segments) {
    const fs::path from = store / (segment.name + ".seg");
    std::error_code no_link;
    fs::remove(file_of(segment.name));
    fs::create_hard_link(from, file_of(segment.name), no_link);
    if (no_link) fs::copy_file(from, file_of(segment.name));
  }
}

std::unique_ptr<SegmentReader> StoreBuilder::find_finished(const std::string& name) const {
  if (!fs::exists(file_of(name))) return nullptr;
  try {
    auto reader = open_segment(name);
    reader->check_all();
    return reader;
  } catch (const Error&) {
    return nullptr;  // torn by a crash: made again
  }
}

UnitFolder StoreBuilder::units(const std::string& name, const std::string& content) const {
  return {units_, name, content};
}

void StoreBuilder::assemble(const std::string& name, const std::string& params,
                            const std::vector<UnitRef>& units) {
  SegmentWriter writer(file_of(name), name, params, all_entries(units));
  std::vector<std::byte> stored;
  for (const UnitRef& ref : units) {
    const auto unit = ref.open();
    for (std::size_t i = 0; i < unit->entries().size(); ++i) {
      unit->read_stored(i, stored);
      writer.append(stored);
    }
  }
  add(writer.finish());
}

void StoreBuilder::assemble_all(const UnitFolder& folder, int count, const std::string& name,
                                const std::string& params) {
  std::vector<UnitRef> refs;
  for (int u = 0; u < count; ++u) refs.push_back({folder, u});
  assemble(name, params, refs);
  folder.clear();
}

void StoreBuilder::record(const SegmentReader& finished) {
  add({finished.name(), finished.id(), finished.bytes()});
}

void StoreBuilder::add(const SegmentRecord& record) {
  std::erase_if(manifest.segments, [&](const SegmentRecord& s) { return s.name == record.name; });
  manifest.segments.push_back(record);
  if (terrain_) {
    terrain_->impl_->add_segment(record);
    terrain_->impl_->manifest.segments = manifest.segments;
  }
}

const Terrain& StoreBuilder::open_terrain() {
  manifest.id = manifest_id(manifest);
  const std::string text = to_text(manifest);
  OutputFile file(store_ / kManifestName);
  file.write_at(0, std::as_bytes(std::span(text)));
  file.publish();
  OpenOptions options;
  options.cache_bytes = context_.memory_limit / 4;
  options.prefetch = false;
  terrain_ = Terrain::open(store_, options);
  terrain_->impl_->known_as = output_.string();
  return *terrain_;
}

void StoreBuilder::write(const SegmentPlan& plan) {
  if (terrain_->has_segment(plan.name) && terrain_->segment_params(plan.name) == plan.params)
    return;
  if (const auto finished = find_finished(plan.name); finished && finished->params() == plan.params)
    return record(*finished);
  const UnitFolder folder = units(plan.name, plan.params);
  std::vector<int> bounds = plan.later_phases;
  bounds.push_back(plan.units);
  int first = 0;
  for (const int end : bounds) {
    for_each_unit(context_, plan.name, end - first, plan.unit_bytes, [&](int u) {
      folder.make(first + u, [&](UnitWriter& unit) {
        UnitSink sink(unit, folder);
        plan.make(first + u, sink);
      });
    });
    first = end;
  }
  assemble_all(folder, plan.units, plan.name, plan.params);
}

// A killed build for other methods leaves segments, or halves of them, that this store is without.
void StoreBuilder::remove_strays() const {
  std::set<fs::path> known{store_ / kManifestName};
  for (const SegmentRecord& segment : manifest.segments) known.insert(file_of(segment.name));
  std::vector<fs::path> strays;
  for (const auto& entry : fs::directory_iterator(store_))
    if (!known.contains(entry.path())) strays.push_back(entry.path());
  for (const fs::path& stray : strays) fs::remove_all(stray);
}

void StoreBuilder::finish() {
  remove_strays();
  manifest.id = manifest_id(manifest);
  for (const SegmentRecord& segment : manifest.segments) sync_file(file_of(segment.name));
  const std::string text = to_text(manifest);
  write_file_durably(store_ / kManifestName, std::as_bytes(std::span(text)));
}

}  // namespace arete::store
