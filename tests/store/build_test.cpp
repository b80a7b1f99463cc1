#include <atomic>
#include <chrono>
#include <csignal>
#include <cstring>
#include <fstream>
#include <random>
#include <thread>

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "arete/core/error.h"
#include "arete/store/output_file.h"
#include "arete/store/part_directory.h"
#include "arete/store/terrain.h"

#include "store/store_fixture.h"

namespace arete::store {
namespace {

namespace fs = std::filesystem;
using Files = std::map<std::string, std::vector<char>>;

Heightfield sample_field() {
  Heightfield field = make_hills(700, 390, 6);
  punch_holes(field, 4, 9);
  return field;
}

// A segment of a method: a block a unit, made from a height tile.
SegmentPlan sample_plan(const Terrain& terrain, const std::string& params) {
  SegmentPlan plan;
  plan.name = "method-1";
  plan.params = params;
  plan.units = static_cast<int>(terrain.keys("heights").size());
  plan.make = [&terrain, params](int unit, BlockSink& sink) {
    const std::uint64_t key = terrain.keys("heights")[static_cast<std::size_t>(unit)];
    const auto tile = terrain.heights(TileId::from_key(key), Fetch::Wait);
    const std::vector<std::int32_t> counts(tile->counts.begin(), tile->counts.begin() + 100);
    sink.add(key, std::as_bytes(std::span(counts)));
  };
  return plan;
}

BuildOptions options_for(const fs::path& output) {
  BuildOptions options;
  options.output = output;
  options.source_key = "sample";
  options.methods = {"one"};
  options.preprocess = [](const Terrain& terrain, Writers& writers) {
    writers.write(sample_plan(terrain, "first"));
  };
  return options;
}

Files build_files(const BuildContext& context) {
  TemporaryFolder folder;
  Heightfield field = sample_field();
  build(field, options_for(folder / "a.arete"), context);
  EXPECT_EQ(read_all_files(folder.path()).size(), read_all_files(folder / "a.arete").size())
      << "something is left beside the store";
  return read_all_files(folder / "a.arete");
}

TEST(Build, BytesDoNotDependOnThreadsOrMemory) {
  const Files one =
      build_files({.threads = 1, .memory_limit = std::size_t{1} << 30U, .progress = {}});
  ASSERT_EQ(one.size(), 5U);
  for (const int threads : {2, 3, 5})
    for (const std::size_t memory : {std::size_t{4} << 20U, std::size_t{1} << 30U}) {
      SCOPED_TRACE(threads);
      EXPECT_EQ(build_files({.threads = threads, .memory_limit = memory, .progress = {}}), one);
    }
}

// Negative control of the comparison: one post more in the source, other bytes.
TEST(Build, BytesDependOnHeights) {
  TemporaryFolder folder;
  Heightfield field = sample_field();
  build(field, options_for(folder / "a.arete"), {});
  field[{699, 389}] = 1;
  build(field, options_for(folder / "b.arete"), {});
  EXPECT_NE(read_all_files(folder / "a.arete"), read_all_files(folder / "b.arete"));
}

// Runs a build that gives up at its n-th progress report; true when it was cancelled.
bool build_until(const fs::path& output, int reports, int threads) {
  Heightfield field = sample_field();
  BuildContext context;
  context.threads = threads;
  context.progress = [&](std::string_view, double) { return reports-- > 0; };
  try {
    build(field, options_for(output), context);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::Cancelled);
    EXPECT_FALSE(fs::exists(output));
    return true;
  }
  return false;
}

TEST(Build, ResumedBytesAreThoseOfOneRun) {
  const Files whole = build_files({});
  int cancelled = 0;
  for (int reports = 0; reports < 60; reports += 5) {
    SCOPED_TRACE(reports);
    TemporaryFolder folder;
    cancelled += build_until(folder / "a.arete", reports, 2) ? 1 : 0;
    if (!fs::exists(folder / "a.arete")) {
      Heightfield field = sample_field();
      build(field, options_for(folder / "a.arete"), {});
    }
    EXPECT_EQ(read_all_files(folder / "a.arete"), whole);
    EXPECT_FALSE(fs::exists(folder / "a.arete.part"));
  }
  EXPECT_GT(cancelled, 5);
}

TEST(Build, ManyCancelsInARowStillFinish) {
  TemporaryFolder folder;
  int runs = 1;
  for (int reports = 2; build_until(folder / "a.arete", reports, 1); reports += 2) ++runs;
  EXPECT_GT(runs, 2);
  EXPECT_EQ(read_all_files(folder / "a.arete"), build_files({}));
}

// A process that dies without a word at a progress report; unit files may be half written.
TEST(Build, KilledBuildsLeaveNothingAndResume) {
  const Files whole = build_files({});
  for (int reports = 1; reports < 40; reports += 7) {
    TemporaryFolder folder;
    const pid_t child = ::fork();
    if (child == 0) {
      Heightfield field = sample_field();
      BuildContext context;
      context.threads = 1;
      int left = reports;
      context.progress = [&](std::string_view, double) {
        if (left-- == 0) ::_exit(0);
        return true;
      };
      build(field, options_for(folder / "a.arete"), context);
      ::_exit(0);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    if (fs::exists(folder / "a.arete")) continue;
    // Damage done by the crash: a torn unit must be made again.
    for (const auto& entry : fs::directory_iterator(folder / "a.arete.part/units"))
      if (reports % 2 == 0) fs::resize_file(entry.path(), fs::file_size(entry.path()) / 2);
    Heightfield field = sample_field();
    build(field, options_for(folder / "a.arete"), {});
    EXPECT_EQ(read_all_files(folder / "a.arete"), whole) << reports;
  }
}

TEST(Build, UnitsOfAnotherSourceAreNotUsed) {
  TemporaryFolder folder;
  build_until(folder / "a.arete", 12, 1);
  Heightfield other = make_hills(700, 390, 77);
  BuildOptions options = options_for(folder / "a.arete");
  options.source_key = "other";
  build(other, options, {});
  build(other, options_for(folder / "b.arete"), {});
  EXPECT_EQ(read_all_files(folder / "a.arete"), read_all_files(folder / "b.arete"));
}

// Messages of a method name the output, not where it is being made; and of a finished store its
// path, whatever it looks like.
TEST(Build, TerrainsAreNamedAfterTheirOutput) {
  TemporaryFolder folder;
  Heightfield field = make_hills(20, 20, 1);
  fs::create_directories(folder / "x.part");
  BuildOptions options = options_for(folder / "x.part/store");
  std::string unfinished;
  options.preprocess = [&](const Terrain& terrain, Writers&) { unfinished = terrain.name(); };
  build(field, options, {});
  EXPECT_EQ(unfinished, options.output);
  EXPECT_EQ(Terrain::open(options.output)->name(), options.output);
}

TEST(Build, TwoBuildersAtOnceGiveOneError) {
  TemporaryFolder folder;
  Heightfield field = sample_field();
  const PartDirectory held(folder / "a.arete", "key");
  try {
    build(field, options_for(folder / "a.arete"), {});
    FAIL() << "the lock was not seen";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::Io);
    EXPECT_NE(std::string(error.what()).find("another build"), std::string::npos);
  }
  EXPECT_TRUE(fs::exists(folder / "a.arete.part"));
}

class FailingSource : public Heightfield {
 public:
  FailingSource(Heightfield field, int row) : Heightfield(std::move(field)), row_(row) {}
  void read_row(int r, std::span<float> row) override {
    if (r == row_) throw Error(ErrorCode::InvalidInput, "row cannot be read");
    Heightfield::read_row(r, row);
  }

 private:
  int row_;
};

TEST(Build, RefusedSourcesLeaveNothing) {
  for (const int row : {0, 128, 389}) {
    TemporaryFolder folder;
    FailingSource source(sample_field(), row);
    EXPECT_THROW(build(source, options_for(folder / "a.arete"), {}), Error);
    EXPECT_TRUE(fs::is_empty(folder.path()));
  }
}

TEST(Build, ForceReplacesAndAFailureKeepsTheOldStore) {
  TemporaryFolder folder;
  Heightfield field = sample_field();
  BuildOptions options = options_for(folder / "a.arete");
  build(field, options, {});
  const Files old = read_all_files(folder / "a.arete");
  options.force = true;
  FailingSource failing(make_hills(700, 390, 8), 300);
  EXPECT_THROW(build(failing, options, {}), Error);
  EXPECT_EQ(read_all_files(folder / "a.arete"), old);
  Heightfield other = make_hills(700, 390, 8);
  build(other, options, {});
  EXPECT_NE(read_all_files(folder / "a.arete"), old);
  EXPECT_FALSE(fs::exists(folder / "a.arete.part"));
}

TEST(Build, AnExistingStoreTakesMethodsOfTheSameHeightsOnly) {
  TemporaryFolder folder;
  Heightfield field = sample_field();
  BuildOptions options = options_for(folder / "a.arete");
  options.preprocess = {};
  options.methods = {};
  build(field, options, {});
  build(field, options_for(folder / "a.arete"), {});
  EXPECT_TRUE(Terrain::open(folder / "a.arete")->has_segment("method-1"));
  EXPECT_EQ(read_all_files(folder / "a.arete"), build_files({}));
  field[{0, 0}] += 40;
  EXPECT_THROW(build(field, options_for(folder / "a.arete"), {}), Error);
}

// Phase one holds numbers; each unit of the second adds up those of all of the first.
TEST(Extend, UnitsOfALaterPhaseReadThoseOfEarlierOnes) {
  TemporaryFolder folder;
  Heightfield field = sample_field();
  BuildOptions options = options_for(folder / "a.arete");
  options.preprocess = [](const Terrain&, Writers& writers) {
    SegmentPlan plan;
    plan.name = "sums";
    plan.units = 8;
    plan.later_phases = {6};
    plan.make = [](int unit, BlockSink& sink) {
      std::uint64_t sum = unit < 6 ? static_cast<std::uint64_t>(unit) : 0;
      for (int earlier = 0; unit >= 6 && earlier < 6; ++earlier) {
        const std::uint64_t key = 10 * static_cast<std::uint64_t>(earlier);
        sink.read_earlier(earlier, key, key + 1,
                          [&](std::uint64_t, std::span<const std::byte> raw) {
                            std::uint64_t number = 0;
                            std::memcpy(&number, raw.data(), sizeof number);
                            sum += number;
                          });
        sink.read_earlier(earlier, key + 1, key + 10,
                          [](std::uint64_t, std::span<const std::byte>) { FAIL(); });
      }
      sink.add(10 * static_cast<std::uint64_t>(unit), std::as_bytes(std::span(&sum, 1)));
    };
    writers.write(plan);
  };
  build(field, options, {});
  const auto terrain = Terrain::open(folder / "a.arete");
  std::vector<std::byte> raw;
  EXPECT_GT(terrain->read_block("sums", 70, raw), 0U);
  EXPECT_EQ(raw[0], std::byte{15});
  EXPECT_EQ(terrain->read_block("sums", 71, raw), 0U);
}

TEST(Extend, AddsSegmentsAndKeepsWhatIsThere) {
  TemporaryFolder folder;
  Heightfield field = sample_field();
  build(field, options_for(folder / "a.arete"), {});
  const Files before = read_all_files(folder / "a.arete");
  int made = 0;
  BuildOptions more;
  more.methods = {"one", "two"};
  more.preprocess = [&](const Terrain& terrain, Writers& writers) {
    SegmentPlan same = sample_plan(terrain, "first");
    same.make = [&](int, BlockSink&) { ++made; };
    writers.write(same);
    SegmentPlan plan = sample_plan(terrain, "second");
    plan.name = "method-2";
    writers.write(plan);
    EXPECT_TRUE(terrain.has_segment("method-2"));
  };
  extend(folder / "a.arete", more, {});
  EXPECT_EQ(made, 0);
  Files after = read_all_files(folder / "a.arete");
  EXPECT_EQ(after.at("method-1.seg"), before.at("method-1.seg"));
  const auto terrain = Terrain::open(folder / "a.arete");
  EXPECT_EQ(terrain->manifest().methods, (std::vector<std::string>{"one", "two"}));
  EXPECT_EQ(terrain->segment_params("method-2"), "second");
  EXPECT_EQ(terrain->check_all() > 0, true);
}

TEST(Extend, ASegmentOfOtherParamsIsReplaced) {
  TemporaryFolder folder;
  Heightfield field = sample_field();
  build(field, options_for(folder / "a.arete"), {});
  BuildOptions more;
  more.preprocess = [&](const Terrain& terrain, Writers& writers) {
    writers.write(sample_plan(terrain, "changed"));
  };
  extend(folder / "a.arete", more, {});
  EXPECT_EQ(Terrain::open(folder / "a.arete")->segment_params("method-1"), "changed");
}

// A disk that takes no more bytes: every limit gives one Error and leaves nothing.
TEST(Build, FullDisksAreOneCleanError) {
  for (int kib = 4; kib <= 400; kib *= 3) {
    TemporaryFolder folder;
    const pid_t child = ::fork();
    if (child == 0) {
      std::signal(SIGXFSZ, SIG_IGN);
      const rlim_t bytes = static_cast<rlim_t>(kib) << 10U;
      const rlimit limit{bytes, bytes};
      ::setrlimit(RLIMIT_FSIZE, &limit);
      Heightfield field = make_hills(700, 700, 1);
      BuildContext context;
      context.threads = 1;
      try {
        build(field, options_for(folder / "a.arete"), context);
      } catch (const Error& error) {
        ::_exit(error.code() == ErrorCode::Io && fs::is_empty(folder.path()) ? 7 : 8);
      }
      ::_exit(9);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    EXPECT_EQ(WEXITSTATUS(status), 7) << kib << " KiB";
  }
}

TEST(Build, TooWideForTheMemoryLimitIsSaid) {
  TemporaryFolder folder;
  Heightfield field = make_hills(5000, 3, 1);
  BuildContext context;
  context.memory_limit = 1 << 20U;
  try {
    build(field, options_for(folder / "a.arete"), context);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::Limit);
  }
}

// The same source, killed while it built for a method and built again without it.
TEST(Build, SegmentsOfAnAbandonedMethodAreNotPublished) {
  TemporaryFolder folder;
  Heightfield field = sample_field();
  BuildOptions options = options_for(folder / "a.arete");
  options.preprocess = [](const Terrain& terrain, Writers& writers) {
    writers.write(sample_plan(terrain, "first"));
    throw Error(ErrorCode::Cancelled, "planted");
  };
  EXPECT_THROW(build(field, options, {}), Error);
  EXPECT_TRUE(fs::exists(folder / "a.arete.part/store/method-1.seg"));
  options.preprocess = {};
  build(field, options, {});
  EXPECT_FALSE(fs::exists(folder / "a.arete/method-1.seg"));
  EXPECT_EQ(read_all_files(folder / "a.arete").size(), 4U);
}

TEST(Build, ForceReplacesStoresOnly) {
  TemporaryFolder folder;
  fs::create_directories(folder / "precious");
  std::ofstream(folder / "precious" / "thesis.txt") << "years of work";
  std::ofstream(folder / "file.tif") << "a DEM";
  Heightfield field = sample_field();
  for (const char* name : {"precious", "file.tif"}) {
    BuildOptions options = options_for(folder / name);
    options.force = true;
    EXPECT_THROW(build(field, options, {}), Error);
  }
  EXPECT_TRUE(fs::exists(folder / "precious" / "thesis.txt"));
  EXPECT_TRUE(fs::exists(folder / "file.tif"));
}

TEST(Build, ATrailingSlashNamesTheSameStore) {
  TemporaryFolder folder;
  Heightfield field = sample_field();
  build(field, options_for(folder.path() / "a.arete/"), {});
  EXPECT_TRUE(fs::exists(folder / "a.arete" / "manifest.json"));
  EXPECT_FALSE(fs::exists(folder / "a.arete" / ".part"));
}

}  // namespace
}  // namespace arete::store
