#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>

#include <gtest/gtest.h>

#include "arete/core/error.h"
#include "arete/lod/bintree/page_layout.h"

#include "lod/built_terrain.h"
#include "lod/recorded_terrain.h"

namespace arete::lod::bintree {
namespace {

namespace fs = std::filesystem;

constexpr float kHole = std::numeric_limits<float>::quiet_NaN();

Heightfield hills(int cols, int rows, std::uint32_t seed, int holes = 0) {
  Heightfield dem = store::make_hills(cols, rows, seed);
  if (holes > 0) store::punch_holes(dem, holes, seed + 1);
  return dem;
}

Heightfield placed(const Heightfield& dem, const std::array<double, 6>& affine) {
  Georef georef;
  georef.world_from_post.m = affine;
  Heightfield copy(dem.cols(), dem.rows(), georef);
  for (int r = 0; r < dem.rows(); ++r)
    for (int c = 0; c < dem.cols(); ++c) copy[{c, r}] = dem[{c, r}];
  copy.set_lattice(Heightfield(dem).lattice());
  return copy;
}

void expect_sound(const Heightfield& dem, const RecordOptions& options = {}) {
  const RecordedTerrain recorded(dem, options);
  AllRecords records(recorded.terrain(), options.delta);
  const auto faults = find_faults(records, recorded, options.delta);
  EXPECT_TRUE(faults.empty()) << faults.size() << " faults, first: " << faults.front();
}

TEST(BintreePreprocess, RecordsBoundEveryPostOfSmallTerrains) {
  for (const auto& [cols, rows] :
       {std::pair{1, 1}, {2, 2}, {3, 3}, {5, 7}, {17, 17}, {33, 20}, {65, 65}, {100, 129}}) {
    SCOPED_TRACE(testing::Message() << cols << " x " << rows);
    expect_sound(hills(cols, rows, 3));
  }
}

TEST(BintreePreprocess, RecordsBoundStrips) {
  for (const auto& [cols, rows] : {std::pair{1, 200}, {200, 1}, {2, 150}, {150, 3}}) {
    SCOPED_TRACE(testing::Message() << cols << " x " << rows);
    expect_sound(hills(cols, rows, 4));
  }
}

TEST(BintreePreprocess, RecordsBoundLandWithHoles) {
  expect_sound(hills(90, 70, 5, 6));
  Heightfield islands = hills(140, 140, 6);
  for (int r = 0; r < 140; ++r)
    for (int c = 0; c < 140; ++c)
      if (c % 20 > 3 || r % 30 > 4) islands[{c, r}] = kHole;
  expect_sound(islands);
}

TEST(BintreePreprocess, RecordsBoundTurnedAndStretchedGrids) {
  expect_sound(placed(hills(70, 50, 7), {12, 0, 0, 0, -90, 0}));
  expect_sound(placed(hills(50, 70, 8), {20, 17, 0, 15, -23, 0}));
}

TEST(BintreePreprocess, RecordsBoundFractionalHeights) {
  expect_sound(rough_dem(80, 60, 9, 0.2));
}

TEST(BintreePreprocess, RecordsBoundTerrainsOfSeveralBlocksAndGroups) {
  Heightfield dem = hills(420, 300, 10);
  for (int r = 20; r < 290; ++r)  // tiles without land
    for (int c = 110; c < 400; ++c) dem[{c, r}] = kHole;
  expect_sound(dem, {.log2_block = Groups::kMinLog2Block});
}

TEST(BintreePreprocess, IncrementalDeltasAreThoseOfTheVertices) {
  expect_sound(hills(65, 50, 11), {.delta = Delta::Incremental});
  expect_sound(hills(300, 270, 12),
               {.delta = Delta::Incremental, .log2_block = Groups::kMinLog2Block});
}

TEST(BintreePreprocess, LevelLandHasNoDeltas) {
  Heightfield dem(40, 30);
  for (int r = 0; r < 30; ++r)
    for (int c = 0; c < 40; ++c) dem[{c, r}] = 1234.5F;
  const RecordedTerrain recorded(dem);
  AllRecords records(recorded.terrain(), Delta::Exact);
  EXPECT_EQ(records[(Post{17, 9})].delta, 0);
  EXPECT_EQ(records[(Post{16, 16})].delta, 0);
  expect_sound(dem);
}

TEST(BintreePreprocess, ALoweredCodeIsCaught) {
  const RecordedTerrain recorded(hills(33, 33, 13));
  std::mt19937 random(14);
  for (int trial = 0; trial < 40; ++trial) {
    AllRecords records(recorded.terrain(), Delta::Exact);
    Record* record = nullptr;
    do {
      record = &records[{static_cast<int>(random() % 33), static_cast<int>(random() % 33)}];
    } while (record->radius == 0 || record->radius == kInfinite || record->delta == 0);
    // The radius is the least code; a delta may be a child's.
    (trial % 2 == 0 ? record->delta : record->radius) -= 1;
    EXPECT_FALSE(find_faults(records, recorded, Delta::Exact).empty());
  }
}

BuildContext context_of(int threads, std::size_t memory_limit = std::size_t{1} << 30U) {
  BuildContext context;
  context.threads = threads;
  context.memory_limit = memory_limit;
  return context;
}

using Files = std::map<std::string, std::vector<char>>;

Files files_of(const BuildContext& context) {
  const RecordedTerrain recorded(hills(700, 560, 15, 3), {.log2_block = Groups::kMinLog2Block},
                                 context);
  return store::read_all_files(recorded.store());
}

TEST(BintreePreprocess, ThreadsAndMemoryDoNotChangeAByte) {
  const Files files = files_of(context_of(1));
  EXPECT_EQ(files_of(context_of(3)), files);
  EXPECT_EQ(files_of(context_of(2, std::size_t{8} << 20U)), files);
}

// Each run is cancelled a few units further on.
TEST(BintreePreprocess, ACancelledBuildGoesOnToTheSameBytes) {
  const Files files = files_of(context_of(1));
  const Heightfield dem = hills(700, 560, 15, 3);
  store::TemporaryFolder folder;
  int calls = 0;
  int allowed = 3;
  BuildContext context = context_of(1);
  context.progress = [&](std::string_view step, double) {
    return step != "bintree" || ++calls <= allowed;
  };
  store::BuildOptions options;
  options.output = folder / "t.arete";
  options.source_key = "test";
  options.preprocess = [&](const store::Terrain& terrain, store::Writers& writers) {
    write_records(terrain, writers, context, {.log2_block = Groups::kMinLog2Block});
  };
  int cancelled = 0;
  for (bool done = false; !done; calls = 0, allowed += 4) {
    Heightfield source = dem;
    try {
      store::build(source, options, context);
      done = true;
    } catch (const Error& error) {
      ASSERT_EQ(error.code(), ErrorCode::Cancelled);
      ++cancelled;
    }
  }
  EXPECT_GT(cancelled, 1);
  EXPECT_EQ(store::read_all_files(folder / "t.arete"), files);
}

// What a build fails with, or an extension where the store is there.
Error failure_of(const store::TemporaryFolder& folder, Heightfield& dem,
                 const std::function<void(const store::Terrain&, store::Writers&)>& preprocess) {
  store::BuildOptions options;
  options.output = folder / "t.arete";
  options.preprocess = preprocess;
  try {
    fs::exists(options.output) ? extend(options.output, options, {}) : build(dem, options, {});
  } catch (const Error& error) {
    return error;
  }
  throw std::logic_error("nothing failed");
}

void write_small_blocks(const store::Terrain& terrain, store::Writers& writers) {
  write_records(terrain, writers, {}, {.log2_block = Groups::kMinLog2Block});
}

// A file, what is wrong, what to do.
void expect_names(const Error& error, const std::string& name) {
  const std::string text = error.what();
  EXPECT_TRUE(text.starts_with(name)) << text;
  EXPECT_EQ(text.find(".part"), std::string::npos) << text;
  EXPECT_GE(std::ranges::count(text, ':'), 2) << text;
}

TEST(BintreePreprocess, AStoreWithDamagedHeightsIsNamed) {
  const store::TemporaryFolder folder;
  Heightfield dem = hills(700, 560, 15);
  build_store(folder, dem);
  std::fstream(folder / "t.arete/heights.seg").seekp(8192) << "damage";
  const Error error = failure_of(folder, dem, write_small_blocks);
  EXPECT_EQ(error.code(), ErrorCode::Corrupt);
  expect_names(error, (folder / "t.arete").string() + ": ");
}

// Finished by another program, with the right hashes.
TEST(BintreePreprocess, AForeignUnitIsNamed) {
  const store::TemporaryFolder folder;
  Heightfield dem = hills(700, 560, 15);
  const Groups groups(dem.cols(), dem.rows(), Groups::kMinLog2Block);
  const auto foreign = [&](const store::Terrain&, store::Writers& writers) {
    store::SegmentPlan plan{"bintree", "bintree-records 1 exact block=256", groups.units(), {}};
    plan.make = [&](int unit, store::BlockSink& sink) {
      if (unit == groups.units() - 1) throw Error(ErrorCode::Cancelled, "planted");
      sink.add(page_key(unit, kMaximaPage), std::array{std::byte{1}});
    };
    for (int g = 1; g < groups.count(); ++g) plan.later_phases.push_back(groups.first_unit(g));
    writers.write(plan);
  };
  EXPECT_EQ(failure_of(folder, dem, foreign).code(), ErrorCode::Cancelled);
  const Error error = failure_of(folder, dem, write_small_blocks);
  EXPECT_EQ(error.code(), ErrorCode::Corrupt);
  expect_names(error, (folder / "t.arete").string());
}

}  // namespace
}  // namespace arete::lod::bintree
