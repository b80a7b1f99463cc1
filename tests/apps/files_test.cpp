#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include <gtest/gtest.h>

#include "arete/core/error.h"
#include "arete/core/heightfield.h"
#include "arete/store/build.h"

#include "open_store.h"
#include "text_file.h"
#include "unfinished.h"

namespace arete::app {
namespace {

namespace fs = std::filesystem;

/// An empty directory of the running test's own, removed at its end.
class FilesTest : public testing::Test {
 protected:
  void SetUp() override {
    const auto* const info = testing::UnitTest::GetInstance()->current_test_info();
    directory_ = fs::path(testing::TempDir()) / (std::string("arete_") + info->name());
    fs::remove_all(directory_);
    fs::create_directories(directory_);
  }
  void TearDown() override { fs::remove_all(directory_); }

  fs::path write(const std::string& name, std::size_t bytes) const {
    const fs::path file = directory_ / name;
    fs::create_directories(file.parent_path());
    std::ofstream(file) << std::string(bytes, 'x');
    return file;
  }

  fs::path directory_;
};

TEST_F(FilesTest, UnfinishedGoes) {
  const fs::path made = directory_ / "frames";
  {
    Unfinished unfinished;
    unfinished.add_directory(made);
    unfinished.add(write("frames/1.png", 3));
    EXPECT_TRUE(fs::exists(made / "1.png"));
  }
  EXPECT_FALSE(fs::exists(made));
}

TEST_F(FilesTest, FinishedStays) {
  {
    Unfinished unfinished;
    unfinished.add(write("a.png", 3));
    unfinished.finish();
  }
  EXPECT_TRUE(fs::exists(directory_ / "a.png"));
}

TEST_F(FilesTest, DirectoriesWithFilesAreRefusedAndKept) {
  const fs::path kept = write("mine/letter.txt", 3);
  {
    Unfinished unfinished;
    EXPECT_THROW(unfinished.add_directory(directory_ / "mine"), Error);
  }
  EXPECT_TRUE(fs::exists(kept));
}

TEST_F(FilesTest, MappedStoresAreMappedAndOthersAreNot) {
  TerrainFlags flags;
  flags.terrain = directory_ / "t.arete";
  store::BuildOptions options;
  options.output = flags.terrain;
  options.source_key = "test";
  Heightfield dem(40, 30);
  store::build(dem, options, {});
  for (const Io io : {Io::Read, Io::Map}) {
    flags.io = io;
    const auto terrain = open_store(flags, flags.terrain);
    std::ifstream in("/proc/self/maps");
    const std::string maps(std::istreambuf_iterator<char>(in), {});
    EXPECT_EQ(maps.find("t.arete/heights.seg") != std::string::npos, io == Io::Map);
    EXPECT_NE(terrain->heights({0, 0, 0}, store::Fetch::Wait), nullptr);
  }
}

TEST_F(FilesTest, TextIsReplacedWhole) {
  const fs::path file = directory_ / "stats.csv";
  write_text(file, "old\n");
  write_text(file, "new\n");
  std::ifstream in(file);
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(in), {}), "new\n");
  EXPECT_EQ(std::distance(fs::directory_iterator(directory_), {}), 1);
}

TEST_F(FilesTest, TextToNowhereNamesTheFile) {
  try {
    write_text(directory_ / "no" / "stats.csv", "x");
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::Io);
    EXPECT_NE(std::string(error.what()).find("stats.csv"), std::string::npos);
  }
}

TEST_F(FilesTest, CacheDropsTheLeastRecentlyUsed) {
  const auto now = fs::file_time_type::clock::now();
  for (int age = 0; age < 4; ++age) {
    const std::string name = "store" + std::to_string(age);
    write(name + "/heights.seg", 1000);
    fs::last_write_time(directory_ / name, now - std::chrono::hours(age));
  }
  drop_oldest(directory_, directory_ / "store3", 2500);
  EXPECT_TRUE(fs::exists(directory_ / "store0"));
  EXPECT_FALSE(fs::exists(directory_ / "store1"));
  EXPECT_FALSE(fs::exists(directory_ / "store2"));
  EXPECT_TRUE(fs::exists(directory_ / "store3")) << "the one in use stays";
  drop_oldest(directory_, directory_ / "store3", 2500);
  EXPECT_TRUE(fs::exists(directory_ / "store0")) << "within the limit nothing goes";
}

}  // namespace
}  // namespace arete::app
