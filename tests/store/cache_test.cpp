#include "arete/store/cache.h"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <random>
#include <thread>

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include "arete/store/terrain.h"

#include "store/memory_file.h"
#include "store/store_fixture.h"

namespace arete::store {
namespace {

constexpr std::size_t kBudget = 10'000;

TEST(BlockCache, NeverExceedsItsBudgetFromManyThreads) {
  BlockCache cache(kBudget);
  std::vector<std::jthread> threads;
  for (unsigned t = 0; t < 4; ++t)
    threads.emplace_back([&cache, t] {
      std::mt19937 random(t);
      for (int i = 0; i < 5000; ++i) {
        const BlockName name{0, random() % 100};
        if (!cache.find(name)) cache.insert(name, std::make_shared<int>(1), random() % 3000);
        ASSERT_LE(cache.resident_bytes(), kBudget);
      }
    });
  threads.clear();
  EXPECT_LE(cache.resident_bytes_max(), kBudget);
  EXPECT_GT(cache.resident_bytes_max(), kBudget / 2);
}

TEST(BlockCache, EvictsTheLeastRecentlyUsed) {
  BlockCache cache(30);
  for (std::uint64_t key = 0; key < 3; ++key) cache.insert({0, key}, std::make_shared<int>(1), 10);
  cache.find({0, 0});
  cache.insert({0, 3}, std::make_shared<int>(1), 10);
  EXPECT_TRUE(cache.contains({0, 0}));
  EXPECT_FALSE(cache.contains({0, 1}));
  EXPECT_NE(cache.insert({0, 9}, std::make_shared<int>(1), 31), nullptr);
  EXPECT_FALSE(cache.contains({0, 9}));
}

class Residency : public testing::Test {
 protected:
  Residency() : field_(make_hills(600, 600, 4)), path_(build_store(folder_, field_)) {}

  static bool wait_for(const std::function<bool()>& done) {
    for (int i = 0; i < 2000 && !done(); ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    return done();
  }

  TemporaryFolder folder_;
  Heightfield field_;
  std::filesystem::path path_;
};

TEST_F(Residency, CacheHoldsItsBudgetWhileAllTilesPass) {
  OpenOptions options;
  options.cache_bytes = 300'000;
  const auto terrain = Terrain::open(path_, options);
  for (int pass = 0; pass < 2; ++pass)
    for (const std::uint64_t key : terrain->keys("heights")) {
      EXPECT_TRUE(terrain->heights(TileId::from_key(key), Fetch::Wait));
      EXPECT_LE(terrain->cache_stats().resident_bytes, options.cache_bytes);
    }
  EXPECT_LE(terrain->cache_stats().resident_bytes_max, options.cache_bytes);
  EXPECT_GT(terrain->cache_stats().misses, terrain->keys("heights").size());
}

TEST_F(Residency, MissedAndWantedTilesArrive) {
  const auto terrain = Terrain::open(path_);
  const TileId missed{0, 1, 2};
  EXPECT_FALSE(terrain->heights(missed, Fetch::Resident));
  EXPECT_EQ(terrain->cache_stats().late, 1U);
  EXPECT_TRUE(wait_for([&] { return terrain->heights(missed, Fetch::Resident) != nullptr; }));
  const std::vector<TileId> wanted{{1, 0, 0}, {0, 3, 3}, {0, 99, 99}, {77, 0, 0}};
  terrain->prefetch(wanted);
  for (const TileId id : {wanted[0], wanted[1]})
    EXPECT_TRUE(wait_for([&] { return terrain->heights(id, Fetch::Resident) != nullptr; }));
  EXPECT_FALSE(terrain->heights(wanted[2], Fetch::Wait));
  EXPECT_FALSE(terrain->heights(wanted[3], Fetch::Wait));
}

TEST_F(Residency, AskingForMoreThanFitsKeepsTheMostWanted) {
  OpenOptions options;
  options.cache_bytes = 400'000;
  const auto terrain = Terrain::open(path_, options);
  std::vector<TileId> wanted;
  for (const std::uint64_t key : terrain->keys("heights")) wanted.push_back(TileId::from_key(key));
  const auto is_resident = [&](TileId id) {
    return terrain->heights(id, Fetch::Resident) != nullptr;
  };
  terrain->prefetch(wanted);
  // The cache holds four tiles; the first three are looked at only when the fourth is in.
  EXPECT_TRUE(wait_for([&] { return terrain->cache_stats().resident_bytes > 250'000; }));
  for (std::size_t i = 0; i < 3; ++i) EXPECT_TRUE(is_resident(wanted[i])) << i;
}

TEST_F(Residency, FailingReadsGiveNullAndAreCounted) {
  auto fail_from = std::make_shared<std::atomic<std::uint64_t>>(~std::uint64_t{0} / 2);
  const auto files = read_all_files(path_);
  OpenOptions options;
  options.open = [&](const std::filesystem::path& path) {
    auto file = std::make_unique<MemoryFile>(files.at(path.filename().string()));
    if (path.filename() == "heights.seg") file->fail_from = fail_from;
    return file;
  };
  const auto terrain = Terrain::open(path_, options);
  *fail_from = files.at("heights.seg").size() / 2;
  std::uint64_t missing = 0;
  for (const std::uint64_t key : terrain->keys("heights"))
    missing += terrain->heights(TileId::from_key(key), Fetch::Wait) ? 0 : 1;
  EXPECT_GT(missing, 0U);
  EXPECT_LT(missing, terrain->keys("heights").size());
  EXPECT_EQ(terrain->cache_stats().damaged, missing);
  std::vector<std::byte> raw;  // past the cache; a block counts once
  EXPECT_ANY_THROW(terrain->read_block("heights", terrain->keys("heights").back(), raw));
  EXPECT_EQ(terrain->cache_stats().damaged, missing);
  *fail_from = ~std::uint64_t{0} / 2;
  const auto anew = Terrain::open(path_, options);
  *fail_from = 0;
  for (int i = 0; i < 2; ++i)
    EXPECT_ANY_THROW(anew->read_block("heights", anew->keys("heights").front(), raw));
  EXPECT_EQ(anew->cache_stats().damaged, 1U);
  *fail_from = files.at("heights.seg").size() / 2;
  EXPECT_EQ(terrain->raster("normals")->read({0, 0, 0}).bytes.size(), 2U * 256 * 256);
  EXPECT_ANY_THROW(terrain->check_all());
}

TEST_F(Residency, DroppingTheSystemsCacheReachesEverySegment) {
  struct Counting : MemoryFile {
    Counting(std::vector<char> bytes, int& dropped)
        : MemoryFile(std::move(bytes)), dropped_(dropped) {}
    void drop_os_cache() const override { ++dropped_; }
    int& dropped_;
  };
  const auto files = read_all_files(path_);
  int dropped = 0;
  OpenOptions options;
  options.open = [&](const std::filesystem::path& path) -> std::unique_ptr<File> {
    return std::make_unique<Counting>(files.at(path.filename().string()), dropped);
  };
  const auto terrain = Terrain::open(path_, options);
  EXPECT_EQ(dropped, 0);
  terrain->drop_os_cache();
  EXPECT_EQ(dropped, static_cast<int>(terrain->manifest().segments.size()));
  const auto file = open_file(path_ / "heights.seg");
  file->drop_os_cache();  // what is read afterwards is the same
  std::vector<std::byte> read(file->size());
  file->read_at(0, read);
  EXPECT_EQ(std::memcmp(read.data(), files.at("heights.seg").data(), read.size()), 0);
}

// Pages of a file that the system holds in memory.
std::size_t pages_held(const std::filesystem::path& path) {
  const std::size_t size = std::filesystem::file_size(path);
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  void* at = ::mmap(nullptr, size, PROT_READ, MAP_SHARED, fd, 0);
  ::close(fd);
  const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  std::vector<unsigned char> held((size + page - 1) / page);
  EXPECT_EQ(::mincore(at, size, held.data()), 0);
  ::munmap(at, size);
  return static_cast<std::size_t>(
      std::ranges::count_if(held, [](unsigned char h) { return (h & 1U) != 0; }));
}

TEST_F(Residency, AFileIsColdAfterTheSystemsCacheWasDropped) {
  const std::filesystem::path path = path_ / "heights.seg";
  for (const auto open : {open_file, map_file}) {
    const auto file = open(path);
    std::vector<std::byte> read(file->size());
    file->read_at(0, read);
    const std::size_t warm = pages_held(path);
    EXPECT_GT(warm, 3U);
    file->drop_os_cache();
    const std::size_t cold = pages_held(path);
    if (open == open_file && cold == warm)
      GTEST_SKIP() << "a file system that cannot forget (tmpfs)";
    EXPECT_EQ(cold, 0U);
    std::vector<std::byte> again(file->size());
    file->read_at(0, again);
    EXPECT_EQ(again, read);
  }
}

TEST_F(Residency, CheckAllReadsEveryPage) {
  const auto terrain = Terrain::open(path_);
  std::uint64_t bytes = 0;
  for (const SegmentRecord& segment : terrain->manifest().segments) bytes += segment.bytes;
  double last = 0;
  EXPECT_EQ(terrain->check_all([&](double done) { last = done; }), bytes / 4096);
  EXPECT_EQ(last, 1);
}

}  // namespace
}  // namespace arete::store
