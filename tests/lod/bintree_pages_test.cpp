#include <algorithm>
#include <chrono>
#include <cstring>
#include <random>
#include <thread>

#include <gtest/gtest.h>

#include "arete/core/error.h"
#include "arete/lod/bintree/page_codec.h"
#include "arete/lod/bintree/page_layout.h"
#include "arete/lod/bintree/record_pages.h"
#include "arete/store/manifest.h"

#include "lod/recorded_terrain.h"
#include "store/memory_file.h"

namespace arete::lod::bintree {
namespace {

const RecordedTerrain& recorded() {
  static const RecordedTerrain kRecorded(store::make_hills(300, 200, 21));
  return kRecorded;
}

std::vector<VertexIndex> some_vertices(const Domain& domain, std::size_t n) {
  std::mt19937 random(22);
  std::vector<VertexIndex> vertices;
  for (std::size_t i = 0; i < n; ++i)
    vertices.push_back(
        domain.index_of({static_cast<int>(random() % 300), static_cast<int>(random() % 200)}));
  return vertices;
}

bool same(const Record& a, const Record& b) {
  return std::memcmp(&a, &b, sizeof a) == 0;
}

// Begins frames until the page is there, or some seconds have passed.
const Record* await(RecordPages& pages, VertexIndex index) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (std::chrono::steady_clock::now() < end) {
    pages.begin_frame();
    if (const Record* record = pages.find(index, OnMissing::Defer)) return record;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return nullptr;
}

// Begins frames until the thread has read a page, or some seconds have passed.
bool await_read(RecordPages& pages) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (std::chrono::steady_clock::now() < end) {
    pages.begin_frame();
    if (pages.counts().prefetched > 0) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return false;
}

TEST(BintreePages, CodecIsLossless) {
  std::mt19937 random(23);
  std::vector<Record> records(kPageRecords);
  for (Record& r : records)
    r = {static_cast<std::int32_t>(random()), static_cast<Code>(random()),
         static_cast<Code>(random())};
  records[7].count = std::numeric_limits<std::int32_t>::min();
  records[8].count = std::numeric_limits<std::int32_t>::max();
  std::vector<std::byte> raw;
  encode_page(records, raw);
  std::vector<Record> back(kPageRecords);
  ASSERT_TRUE(decode_page(raw, back));
  for (std::size_t i = 0; i < kPageRecords; ++i) ASSERT_TRUE(same(records[i], back[i])) << i;
  raw.pop_back();
  EXPECT_FALSE(decode_page(raw, back));
}

TEST(BintreePages, EveryPostStandsOnItsPage) {
  for (int k = 1; k <= 7; ++k) {
    const Domain domain(k);
    std::size_t met = 0;
    for (std::uint64_t page = 0; page << kLog2PageRecords < domain.index_end(); ++page)
      for_each_post(domain, page, [&](std::size_t slot, Post post) {
        ++met;
        ASSERT_EQ(domain.index_of(post), (page << kLog2PageRecords) + slot);
      });
    EXPECT_EQ(met, static_cast<std::size_t>(domain.side() + 1) *
                       static_cast<std::size_t>(domain.side() + 1));
  }
}

TEST(BintreePages, ASmallBudgetGivesTheSameRecordsAndIsKept) {
  RecordPages all(recorded().terrain(), {.prefetch = Prefetch::Off});
  RecordPages few(recorded().terrain(),
                  {.budget_bytes = 3 * kRecordPageBytes, .prefetch = Prefetch::Off});
  for (const VertexIndex v : some_vertices(all.domain(), 3000)) {
    few.begin_frame();
    ASSERT_TRUE(same(*few.find(v, OnMissing::Wait), *all.find(v, OnMissing::Wait)));
    ASSERT_LE(few.counts().resident_bytes_max, 3 * kRecordPageBytes);
  }
  EXPECT_GT(few.counts().bytes_read, all.counts().bytes_read);
  EXPECT_GT(all.counts().resident_bytes, 3 * kRecordPageBytes);
}

TEST(BintreePages, PagesOfTheFrameStayAndAFullBudgetGivesNull) {
  RecordPages pages(recorded().terrain(),
                    {.budget_bytes = 4 * kRecordPageBytes, .prefetch = Prefetch::Off});
  pages.begin_frame();
  std::vector<std::pair<const Record*, Record>> seen;
  std::uint64_t late = 0;
  for (const VertexIndex v : some_vertices(pages.domain(), 500)) {
    const Record* record = pages.find(v, OnMissing::Wait);
    if (record == nullptr)
      ++late;
    else
      seen.emplace_back(record, *record);
  }
  EXPECT_EQ(pages.counts().touched, 4U);
  EXPECT_EQ(pages.counts().faults, 4U);
  EXPECT_GT(late, 0U);
  EXPECT_EQ(pages.counts().late, late);
  for (const auto& [record, was] : seen) EXPECT_TRUE(same(*record, was));
  pages.begin_frame();
  EXPECT_NE(pages.find(some_vertices(pages.domain(), 500).back(), OnMissing::Wait), nullptr);
}

TEST(BintreePages, ADeferredPageComesInAtALaterFrame) {
  RecordPages pages(recorded().terrain(), {});
  const VertexIndex v = pages.domain().index_of({131, 57});
  EXPECT_EQ(pages.find(v, OnMissing::Defer), nullptr);
  EXPECT_EQ(pages.counts().late, 1U);
  const Record* record = await(pages, v);
  ASSERT_NE(record, nullptr);
  EXPECT_EQ(recorded().terrain().z_of(record->count), (recorded().dem()[{131, 57}]));
  EXPECT_EQ(pages.counts().prefetched, 1U);
}

TEST(BintreePages, PrefetchedPagesNeedNoFault) {
  RecordPages pages(recorded().terrain(), {});
  const VertexIndex v = pages.domain().index_of({77, 99});
  const std::vector<std::uint64_t> wanted{RecordPages::page_of(v)};
  pages.ask({}, wanted);
  ASSERT_TRUE(await_read(pages));
  EXPECT_NE(pages.find(v, OnMissing::Defer), nullptr);
  EXPECT_EQ(pages.counts().faults, 0U);
}

TEST(BintreePages, WithoutPrefetchOnlyWhatWasMissedIsRead) {
  const Domain domain = Domain::over(300, 200);
  const VertexIndex v = domain.index_of({77, 99});
  const VertexIndex missed = domain.index_of({131, 57});
  const std::vector<std::uint64_t> ahead{RecordPages::page_of(v)};
  ASSERT_NE(ahead[0], RecordPages::page_of(missed));
  for (const Prefetch prefetch : {Prefetch::Off, Prefetch::On}) {
    RecordPages pages(recorded().terrain(), {.prefetch = prefetch});
    pages.begin_frame();
    EXPECT_EQ(pages.find(missed, OnMissing::Defer), nullptr);
    // What is read ahead comes before what is missed a frame later, so it was not forgotten.
    pages.ask(std::vector{RecordPages::page_of(missed)}, ahead);
    ASSERT_NE(await(pages, missed), nullptr);
    const VertexIndex later = domain.index_of({201, 9});
    ASSERT_NE(await(pages, later), nullptr);
    EXPECT_EQ(pages.find(v, OnMissing::Defer) == nullptr, prefetch == Prefetch::Off);
    EXPECT_EQ(pages.counts().faults, 0U);
  }
}

TEST(BintreePages, TheLeastBudgetIsReadUnderDefer) {
  for (const std::size_t slots : {1, 2, 3}) {
    RecordPages pages(recorded().terrain(), {.budget_bytes = slots * kRecordPageBytes});
    for (const VertexIndex v : some_vertices(pages.domain(), 10))
      ASSERT_NE(await(pages, v), nullptr) << slots;
    EXPECT_LE(pages.counts().resident_bytes_max, slots * kRecordPageBytes);
  }
}

TEST(BintreePages, ManyRequestsUnderASmallBudgetLoseNoPage) {
  RecordPages pages(recorded().terrain(), {.budget_bytes = 16 * kRecordPageBytes});
  RecordPages all(recorded().terrain(), {.prefetch = Prefetch::Off});
  const auto vertices = some_vertices(pages.domain(), 4000);
  std::mt19937 random(24);
  for (std::size_t i = 0; i + 8 < vertices.size(); i += 8) {
    pages.begin_frame();
    std::vector<std::uint64_t> wanted;
    for (std::size_t k = 0; k < 8; ++k) wanted.push_back(RecordPages::page_of(vertices[i + k]));
    if (random() % 2 == 0) pages.ask({}, wanted);
    for (std::size_t k = 0; k < 8; ++k) {
      const auto how = random() % 3 == 0 ? OnMissing::Defer : OnMissing::Wait;
      const Record* record = pages.find(vertices[i + k], how);
      ASSERT_TRUE(record != nullptr || how == OnMissing::Defer);
      const Record* expected = all.find(vertices[i + k], OnMissing::Wait);
      ASSERT_TRUE(record == nullptr || same(*record, *expected));
    }
    ASSERT_LE(pages.counts().resident_bytes_max, 16 * kRecordPageBytes);
  }
}

/// The recorded terrain, whose pages from some byte of their segment on cannot be read.
class Damaged {
 public:
  Damaged() {
    const auto files = store::read_all_files(recorded().store());
    store::OpenOptions options;
    options.open = [&](const std::filesystem::path& path) -> std::unique_ptr<store::File> {
      auto file = std::make_unique<store::MemoryFile>(files.at(path.filename().string()));
      if (path.filename() == "bintree.seg") file->fail_from = fail_from_;
      return file;
    };
    terrain_ = store::Terrain::open(recorded().store(), options);
  }
  const store::Terrain& terrain() const { return *terrain_; }
  void fail_from(std::uint64_t byte) { *fail_from_ = byte; }

 private:
  std::shared_ptr<std::atomic<std::uint64_t>> fail_from_ =
      std::make_shared<std::atomic<std::uint64_t>>(~std::uint64_t{0});
  std::unique_ptr<store::Terrain> terrain_;
};

TEST(BintreePages, ADamagedPageIsNullAndTheOthersAreThere) {
  Damaged damaged;
  RecordPages pages(damaged.terrain(), {.prefetch = Prefetch::Off});
  EXPECT_EQ(damaged.terrain().cache_stats().damaged, 0U);
  damaged.fail_from(20000);
  std::uint64_t lost = 0;
  std::uint64_t found = 0;
  for (const VertexIndex v : some_vertices(pages.domain(), 500))
    ++(pages.find(v, OnMissing::Wait) == nullptr ? lost : found);
  EXPECT_GT(lost, 0U);
  EXPECT_GT(found, 0U);
  EXPECT_EQ(pages.counts().late, lost);
  EXPECT_GT(pages.counts().damaged, 0U);
  EXPECT_LT(pages.counts().damaged, lost);
  EXPECT_EQ(damaged.terrain().cache_stats().damaged, pages.counts().damaged);
}

TEST(BintreePages, ADamagedPageIsReadOnceUnderDefer) {
  Damaged damaged;
  RecordPages pages(damaged.terrain(), {});
  damaged.fail_from(0);
  const VertexIndex v = pages.domain().index_of({131, 57});
  const std::uint64_t page = RecordPages::page_of(v);
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (!pages.holds(page) && std::chrono::steady_clock::now() < end) {
    pages.begin_frame();
    EXPECT_EQ(pages.find(v, OnMissing::Defer), nullptr);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_TRUE(pages.holds(page));
  EXPECT_EQ(pages.counts().damaged, 1U);
  damaged.fail_from(~std::uint64_t{0});  // what comes now was read again
  for (int i = 0; i < 5; ++i) {
    pages.begin_frame();
    EXPECT_EQ(pages.find(v, OnMissing::Defer), nullptr);
    pages.ask(std::vector{page}, {});
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  EXPECT_EQ(pages.counts().bytes_read, 0U);
  EXPECT_EQ(pages.counts().damaged, 1U);
}

/// A file each read of which takes its time.
class SlowFile final : public store::File {
 public:
  explicit SlowFile(std::unique_ptr<store::File> file) : file_(std::move(file)) {}
  std::uint64_t size() const override { return file_->size(); }
  void read_at(std::uint64_t offset, std::span<std::byte> out) const override {
    std::this_thread::sleep_for(std::chrono::milliseconds(3));
    file_->read_at(offset, out);
  }

 private:
  std::unique_ptr<store::File> file_;
};

// Both what waits and what has begun: the thread has one page of one, then one of four.
TEST(BintreePages, WaitTakesBackWhatTheThreadHas) {
  store::OpenOptions options;
  options.open = [](const std::filesystem::path& path) -> std::unique_ptr<store::File> {
    return std::make_unique<SlowFile>(store::open_file(path));
  };
  const auto terrain = store::Terrain::open(recorded().store(), options);
  RecordPages all(recorded().terrain(), {.prefetch = Prefetch::Off});
  for (const std::size_t slots : {1, 4}) {
    RecordPages pages(*terrain, {.budget_bytes = slots * kRecordPageBytes});
    std::vector<std::uint64_t> different;
    std::vector<VertexIndex> vertices;
    for (const VertexIndex v : some_vertices(pages.domain(), 500))
      if (std::ranges::count(different, RecordPages::page_of(v)) == 0) {
        different.push_back(RecordPages::page_of(v));
        vertices.push_back(v);
      }
    ASSERT_GT(vertices.size(), 3 * slots);
    for (std::size_t first = 0; first + slots < vertices.size(); first += slots) {
      pages.begin_frame();
      pages.ask({}, std::span(different).subspan(first + slots, 1));
      for (std::size_t k = 0; k < slots; ++k) {
        const Record* record = pages.find(vertices[first + k], OnMissing::Wait);
        ASSERT_NE(record, nullptr) << slots << " slots, page " << first + k;
        ASSERT_TRUE(same(*record, *all.find(vertices[first + k], OnMissing::Wait)));
      }
    }
    EXPECT_LE(pages.counts().resident_bytes_max, slots * kRecordPageBytes);
  }
}

TEST(BintreePages, PagesWithoutLandAreNotStoredAndReadAsZero) {
  const RecordedTerrain strip(store::make_hills(600, 3, 25));
  RecordPages pages(strip.terrain(), {.prefetch = Prefetch::Off});
  const Record* record = pages.find(pages.domain().index_of({301, 701}), OnMissing::Wait);
  ASSERT_NE(record, nullptr);
  EXPECT_TRUE(same(*record, Record{}));
  EXPECT_EQ(pages.counts().touched, 0U);
  EXPECT_LT(strip.terrain().keys("bintree").size(), 200U);
}

TEST(BintreePages, KnowsTheLargestDeltaOfEachDepth) {
  const RecordedTerrain cut(store::make_hills(300, 280, 26), {.log2_block = Groups::kMinLog2Block});
  RecordPages pages(cut.terrain(), {});
  AllRecords records(cut.terrain(), Delta::Exact);
  const Domain& domain = pages.domain();
  std::vector<double> most(static_cast<std::size_t>(domain.depths()), 0.0);
  for (int r = 0; r <= domain.side(); ++r) {
    for (int c = 0; c <= domain.side(); ++c) {
      const int depth = Domain::depth_of(domain.index_of({c, r}));
      if (depth > 0) {
        double& at = most[static_cast<std::size_t>(depth)];
        at = std::max<double>(at, value(records[{c, r}].delta));
      }
    }
  }
  for (int depth = 1; depth < domain.depths(); ++depth)
    EXPECT_EQ(pages.delta_max(depth), most[static_cast<std::size_t>(depth)]) << depth;
}

TEST(BintreePages, AMappedSegmentGivesTheSame) {
  store::OpenOptions options;
  options.open = store::map_file;
  const auto terrain = store::Terrain::open(recorded().store(), options);
  RecordPages mapped(*terrain, {});
  RecordPages read(recorded().terrain(), {});
  for (const VertexIndex v : some_vertices(read.domain(), 500))
    ASSERT_TRUE(same(*mapped.find(v, OnMissing::Wait), *read.find(v, OnMissing::Wait)));
}

std::string refusal(const store::Terrain& terrain, Delta delta, ErrorCode code) {
  try {
    const RecordPages pages(terrain, {.delta = delta});
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), code);
    return error.what();
  }
  return "opened";
}

TEST(BintreePages, AStoreWithoutRecordsSaysHowToAddThem) {
  store::TemporaryFolder folder;
  Heightfield dem = store::make_hills(20, 20, 1);
  const auto terrain = store::Terrain::open(store::build_store(folder, dem));
  EXPECT_EQ(
      refusal(*terrain, Delta::Exact, ErrorCode::NotFound),
      terrain->name() + ": has no segment \"bintree\": add it with arete build --methods soar");
  EXPECT_EQ(refusal(*terrain, Delta::Incremental, ErrorCode::NotFound),
            terrain->name() +
                ": has no segment \"bintree-incremental\": add it with arete build --methods soar "
                "--set delta=incremental");
}

TEST(BintreePages, ARecordsSegmentOfAnotherTerrainIsRefusedByName) {
  const auto files = store::read_all_files(recorded().store());
  const auto open = [&](int rows) {
    store::OpenOptions options;
    options.open = [&](const std::filesystem::path& path) -> std::unique_ptr<store::File> {
      std::vector<char> bytes = files.at(path.filename().string());
      if (path.filename() == "manifest.json") {
        store::Manifest manifest = store::parse_manifest({bytes.data(), bytes.size()}, "m");
        manifest.rows = rows;
        const std::string text = store::to_text(manifest);
        bytes.assign(text.begin(), text.end());
      }
      return std::make_unique<store::MemoryFile>(std::move(bytes));
    };
    return store::Terrain::open(recorded().store(), options);
  };
  const std::string name = recorded().terrain().name();
  EXPECT_EQ(refusal(*open(2000), Delta::Exact, ErrorCode::Corrupt),
            name + ": bintree.seg does not fit this terrain: build it again with --force");
  EXPECT_EQ(refusal(*open(2000000), Delta::Exact, ErrorCode::Limit),
            name +
                ": 300 x 2000000 posts: soar and smart take at most 1048577 a side: use "
                "geomipmap");
}

}  // namespace
}  // namespace arete::lod::bintree
