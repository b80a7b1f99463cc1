// Out of core: what a flight does while records are missing, and that the checks of it catch
// faults.
#include "arete/proof/late_flight.h"

#include <chrono>
#include <cstring>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <sys/mman.h>

#include "lod/built_terrain.h"

namespace arete::proof {
namespace {

constexpr std::uint64_t kPages = 80, kBudgetBytes = kPages * 4096;
constexpr double kTolerance = 6;
// What a flight's lists and arrays grow to beside the pages: 4.2 MB of smart, measured.
constexpr std::uint64_t kBesideBytes = std::uint64_t{8} << 20U;
constexpr lod::RefineOptions kDefer{.tolerance_px = kTolerance,
                                    .on_missing = lod::OnMissing::Defer};

/// A file each read of which takes its time.
class SlowFile final : public store::File {
 public:
  explicit SlowFile(std::unique_ptr<store::File> file) : file_(std::move(file)) {}
  std::uint64_t size() const override { return file_->size(); }
  void read_at(std::uint64_t offset, std::span<std::byte> out) const override {
    std::this_thread::sleep_for(std::chrono::microseconds(300));
    file_->read_at(offset, out);
  }

 private:
  std::unique_ptr<store::File> file_;
};

/// An engine whose lists are spoilt after it made them.
class Spoilt final : public lod::Engine {
 public:
  Spoilt(lod::Engine& engine, std::function<void(DrawList&)> spoil)
      : engine_(engine), spoil_(std::move(spoil)) {}
  void refine(const View& view, const lod::RefineOptions& options, DrawList& out) override {
    engine_.refine(view, options, out);
    spoil_(out);
  }
  lod::Claims claims(const lod::RefineOptions& options) const override {
    return engine_.claims(options);
  }
  lod::Footprint footprint() const override { return engine_.footprint(); }
  std::span<const Vertex> vertices(BlockKey key) const override { return engine_.vertices(key); }
  std::span<const std::uint32_t> indices(BlockKey key) const override {
    return engine_.indices(key);
  }

 private:
  lod::Engine& engine_;
  std::function<void(DrawList&)> spoil_;
};

#ifdef __SANITIZE_ADDRESS__  // keeps for a while what was given back
constexpr bool kTellsMemory = false;
#else
constexpr bool kTellsMemory = true;
#endif

std::uint64_t growth(const LateFlight& flown) {
  return flown.process_bytes_max - flown.process_bytes_first;
}

class LateFlightTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    terrain_ = new lod::BuiltTerrain(lod::rough_dem(700, 650, 9, 0.05));
  }
  static void TearDownTestSuite() { delete terrain_; }

  LateFlightTest() {
    store::OpenOptions options;
    options.open = [](const std::filesystem::path& file) -> std::unique_ptr<store::File> {
      if (file.filename() != "bintree.seg") return store::open_file(file);
      return std::make_unique<SlowFile>(store::open_file(file));
    };
    opened_ = terrain_->open(options);
    for (int i = 0; i < 200; ++i)
      flight_.push_back(make_view({.eye = {2000 + 30.0 * i, -16000 + 30.0 * i, 900},
                                   .yaw = 0.4,
                                   .pitch = -0.3,
                                   .near_m = 1},
                                  320, 240));
  }

  std::unique_ptr<lod::Engine> open(const char* method, lod::Params params = {}) const {
    params.emplace("pages", std::to_string(kPages));
    return lod::find_engine(method).open(*opened_, params);
  }

  static const lod::BuiltTerrain* terrain_;
  std::unique_ptr<store::Terrain> opened_;
  std::vector<View> flight_;
};

const lod::BuiltTerrain* LateFlightTest::terrain_ = nullptr;

TEST_F(LateFlightTest, KeepsBudgetBoundAndSurfaceWithoutWaiting) {
  ASSERT_GE(opened_->keys("bintree").size(), 4 * kPages);
  const Reference reference(terrain_->dem(), 1);
  for (const char* method : {"soar", "smart"}) {
    SCOPED_TRACE(method);
    const LateFlight flown = fly_late(*open(method), flight_, kDefer, 2);
    EXPECT_EQ(flown.frames, 200);
    EXPECT_GT(flown.late_frames, 0);
    EXPECT_EQ(flown.pages_waited_for, 0U);
    EXPECT_LE(flown.page_bytes_max, kBudgetBytes);
    EXPECT_GT(flown.page_bytes_max, kBudgetBytes * 3 / 4);  // it does bind
    if (kTellsMemory) {
      EXPECT_LE(growth(flown), kBudgetBytes + kBesideBytes);
    }
    const auto engine = open(method);
    const FrameChecks checks = check_late(keep_late(*engine, flight_, kDefer, 2), reference, 40, 1);
    EXPECT_EQ(checks.cracks, 0U);
    EXPECT_GT(checks.measured, 3);
    EXPECT_GT(checks.worst_px, kTolerance);  // late enough to be seen
    EXPECT_LE(checks.worst_claim_share, 1);
  }
}

TEST_F(LateFlightTest, WithoutPrefetchMoreIsLate) {
  const LateFlight with = fly_late(*open("smart"), flight_, kDefer, 2);
  const LateFlight without = fly_late(*open("smart", {{"prefetch", "off"}}), flight_, kDefer, 2);
  EXPECT_GT(without.late_frames, with.late_frames);
  EXPECT_GT(without.late_vertices, with.late_vertices);
}

TEST_F(LateFlightTest, OverspendingAndWaitingAreCaught) {
  const auto engine = open("smart");
  Spoilt greedy(*engine, [](DrawList& list) { list.stats.page_bytes += kBudgetBytes; });
  EXPECT_GT(fly_late(greedy, flight_, kDefer, 0).page_bytes_max, kBudgetBytes);
  const auto waiting = open("smart");
  EXPECT_GT(fly_late(*waiting, flight_, {.tolerance_px = kTolerance}, 0).pages_waited_for, 0U);
}

TEST_F(LateFlightTest, PagesThatNoBudgetKnowsOfAreCaught) {
  if (!kTellsMemory) GTEST_SKIP() << "the sanitizer keeps memory";
  const auto engine = open("smart");
  // Memory that the process has not had before, touched bit by bit.
  constexpr std::size_t kHoard = 4 * kBesideBytes;
  void* const at =
      ::mmap(nullptr, kHoard, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  ASSERT_NE(at, MAP_FAILED);
  char* next = static_cast<char*>(at);
  Spoilt hoarding(*engine, [&](DrawList&) {
    std::memset(next, 'h', kHoard / flight_.size());
    next += kHoard / flight_.size();
  });
  const LateFlight hoarded = fly_late(hoarding, flight_, kDefer, 0);
  ::munmap(at, kHoard);
  EXPECT_LE(hoarded.page_bytes_max, kBudgetBytes);
  EXPECT_GT(growth(hoarded), kBudgetBytes + kBesideBytes);
}

TEST_F(LateFlightTest, BoastsAndCracksAreCaught) {
  const Reference reference(terrain_->dem(), 1);
  const auto engine = open("smart");
  Spoilt boasting(*engine, [](DrawList& list) { list.stats.achieved_error_px /= 3; });
  const auto boasts = keep_late(boasting, flight_, kDefer, 2);
  EXPECT_GT(check_late(boasts, reference, 40, 1).worst_claim_share, 1);
  const auto strips = open("soar");
  Spoilt torn(*strips, [](DrawList& list) {
    for (std::size_t i = 0; i + 1 < list.indices.size(); i += 7)
      list.indices[i] = list.indices[i + 1];
  });
  EXPECT_GT(check_late(keep_late(torn, flight_, kDefer, 0), reference, 0, 1).cracks, 0U);
}

}  // namespace
}  // namespace arete::proof
