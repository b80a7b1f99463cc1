#include "arete/store/publish.h"

#include <atomic>
#include <chrono>
#include <fstream>
#include <map>
#include <thread>

#include "arete/core/error.h"
#include "arete/store/output_file.h"
#include "arete/store/part_directory.h"
#include "arete/store/terrain.h"

#include "store/store_fixture.h"

namespace arete::store {
namespace {

namespace fs = std::filesystem;

TEST(Publish, FallsBackToTheOldStoreWhenItCannotRename) {
  TemporaryFolder folder;
  fs::create_directories(folder / "old");
  write_file_durably(folder / "old/keep", std::as_bytes(std::span("old")));
  EXPECT_THROW(publish_directory(folder / "absent", folder / "old", folder / "retired"), Error);
  EXPECT_TRUE(fs::exists(folder / "old/keep"));
}

// Opening reads several files by name; a store that takes the other's place meanwhile must not mix.
TEST(Publish, ReadersOpenTheOldOrTheNewStore) {
  TemporaryFolder folder;
  std::vector<std::string> ids;
  for (const std::uint32_t seed : {1U, 2U}) {
    Heightfield field = make_hills(140, 140, seed);
    BuildOptions options;
    options.output = folder / (seed == 1 ? "a.arete" : "b.arete");
    build(field, options, {});
    ids.push_back(Terrain::open(options.output)->manifest().id);
  }
  std::atomic<bool> done = false;
  std::jthread writer([&] {
    for (int i = 0; i < 60; ++i) {
      publish_directory(folder / "b.arete", folder / "a.arete", folder / "retired");
      // No builder is quicker: two exchanges during one open would look like none.
      std::this_thread::sleep_for(std::chrono::milliseconds(3));
    }
    done = true;
  });
  std::map<std::string, int> opened;
  while (!done)
    ++opened[Terrain::open(folder / "a.arete", {.prefetch = false, .open = {}})->manifest().id];
  EXPECT_EQ(opened.size(), 2U);
  EXPECT_TRUE(opened.contains(ids[0]) && opened.contains(ids[1]));
}

// Each builder in turn owns the directory alone, from its lock to the end of its removal.
TEST(PartDirectory, RemovalDeletesNothingOfTheNextBuilder) {
  TemporaryFolder folder;
  std::atomic<int> owned{0};
  std::atomic<int> lost{0};
  const auto work = [&](int builder) {
    const std::string name = std::to_string(builder);
    for (int i = 0; i < 12; ++i) {
      try {
        PartDirectory part(folder / "a.arete", name);
        std::ofstream(part.units() / name) << name;
        std::this_thread::yield();
        lost += fs::exists(part.units() / name) ? 0 : 1;
        ++owned;
        part.remove();
      } catch (const Error& error) {
        lost += std::string(error.what()).find("another build") == std::string::npos ? 1 : 0;
      }
    }
  };
  {
    std::vector<std::jthread> builders;
    for (int b = 0; b < 4; ++b) builders.emplace_back(work, b);
  }
  EXPECT_GT(owned, 1);
  EXPECT_EQ(lost, 0);
  EXPECT_TRUE(fs::is_empty(folder.path()));
}

TEST(PartDirectory, OneThatCannotBePreparedIsRemoved) {
  TemporaryFolder folder;
  fs::create_directories(folder / "a.arete.part/key.tmp/in the way");
  EXPECT_THROW(PartDirectory(folder / "a.arete", "key"), Error);
  EXPECT_TRUE(fs::is_empty(folder.path()));
}

// Once the old store may lie in the part directory, the same command must not take it for its own
// work.
TEST(PartDirectory, WithoutItsKeyNothingIsResumed) {
  TemporaryFolder folder;
  for (const bool forget : {false, true}) {
    {
      PartDirectory part(folder / "a.arete", "key");
      std::ofstream(part.store() / "heights.seg") << "of the old store";
      if (forget) part.forget_key();
    }
    PartDirectory again(folder / "a.arete", "key");
    EXPECT_EQ(fs::exists(again.store() / "heights.seg"), !forget);
  }
}

// What a kill between the two renames of a replacement leaves where the file system cannot exchange
// names: the old store is in the part directory only.
class RetiredStore : public testing::Test {
 protected:
  RetiredStore() {
    build(field_, options_for(1), {});
    old_files_ = read_all_files(output());
    retire();
  }
  fs::path output() const { return folder_ / "a.arete"; }
  fs::path part() const { return folder_ / "a.arete.part"; }
  void retire() const {
    fs::create_directories(part());
    fs::rename(output(), part() / "retired");
  }
  // Of the terrain that stands, or with another key of its replacement.
  BuildOptions options_for(int key) const {
    BuildOptions options;
    options.output = output();
    options.source_key = std::to_string(key);
    options.force = key != 1;
    return options;
  }

  TemporaryFolder folder_;
  Heightfield field_ = make_hills(140, 70, 1);
  Heightfield other_ = make_hills(140, 70, 2);
  std::map<std::string, std::vector<char>> old_files_;
};

TEST_F(RetiredStore, IsBackWhenTheNextBuildIsRefused) {
  BuildOptions options = options_for(2);
  options.preprocess = [](const Terrain&, Writers&) {
    throw Error(ErrorCode::Limit, "planted: refused");
  };
  EXPECT_THROW(build(other_, options, {}), Error);
  EXPECT_EQ(read_all_files(output()), old_files_);
  EXPECT_FALSE(fs::exists(part()));
}

TEST_F(RetiredStore, IsBackWhenTheNextBuildIsCancelled) {
  BuildContext context;
  context.progress = [](std::string_view, double) { return false; };
  EXPECT_THROW(build(other_, options_for(2), context), Error);
  EXPECT_EQ(read_all_files(output()), old_files_);
}

TEST_F(RetiredStore, IsReplacedByTheCommandGivenAgain) {
  build(other_, options_for(2), {});
  EXPECT_NE(read_all_files(output()), old_files_);
  EXPECT_FALSE(fs::exists(part()));
}

TEST_F(RetiredStore, IsAddedToAndNotBuiltAnewWithoutForce) {
  BuildOptions plain = options_for(2);
  plain.force = false;
  EXPECT_THROW(build(other_, plain, {}), Error);
  EXPECT_EQ(read_all_files(output()), old_files_);
  EXPECT_FALSE(fs::exists(part()));
  retire();
  extend(output(), options_for(1), {});
  EXPECT_EQ(read_all_files(output()), old_files_);
  EXPECT_FALSE(fs::exists(part()));
}

// An error between the renames, and another on the way back: removal is the last chance.
TEST_F(RetiredStore, OutlivesThePartDirectory) {
  fs::rename(part() / "retired", output());
  PartDirectory directory(output(), "key");
  retire();
  directory.remove();
  EXPECT_EQ(read_all_files(output()), old_files_);
  EXPECT_FALSE(fs::exists(part()));
}

TEST_F(RetiredStore, OfAFinishedReplacementGoes) {
  BuildOptions options;
  options.output = folder_ / "b.arete";
  build(other_, options, {});
  const auto new_files = read_all_files(folder_ / "b.arete");
  fs::rename(folder_ / "b.arete", output());
  const PartDirectory directory(output(), "key");
  EXPECT_FALSE(fs::exists(directory.retired()));
  EXPECT_EQ(read_all_files(output()), new_files);
}

TEST_F(RetiredStore, IsNotTouchedWhileAnotherBuildIsAtWork) {
  fs::rename(part() / "retired", output());
  const PartDirectory held(output(), "key");
  retire();
  EXPECT_THROW(build(other_, options_for(2), {}), Error);
  EXPECT_TRUE(fs::exists(held.retired()));
}

// A replacement at work may stand between its two renames for a while.
TEST_F(RetiredStore, ReadersWaitForAReplacementAtWork) {
  OpenOptions options;
  int opened = 0;
  options.open = [&](const fs::path& path) {
    if (++opened == 6) fs::rename(part() / "retired", output());
    return open_file(path);
  };
  EXPECT_NO_THROW(Terrain::open(output(), options));
}

TEST_F(RetiredStore, ReadersSayWhereItIs) {
  for (const fs::path& name : {output(), output() / ""}) {
    try {
      Terrain::open(name);
      FAIL();
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::NotFound);
      EXPECT_NE(std::string(error.what()).find("a.arete.part/retired"), std::string::npos)
          << error.what();
    }
  }
  EXPECT_TRUE(fs::exists(part() / "retired"));
}

}  // namespace
}  // namespace arete::store
