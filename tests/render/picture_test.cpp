#include "arete/render/picture.h"

#include <cstdlib>
#include <fstream>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <png.h>

#include "arete/core/error.h"

namespace arete::render {
namespace {

std::filesystem::path fresh_folder(const char* name) {
  const auto folder = std::filesystem::path(::testing::TempDir()) / name;
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  return folder;
}

std::vector<std::uint8_t> noise(int width, int height) {
  std::mt19937 random(1);
  std::vector<std::uint8_t> rgb(static_cast<std::size_t>(width * height * 3));
  for (auto& v : rgb) v = static_cast<std::uint8_t>(random());
  return rgb;
}

TEST(WritePng, IsReadBackExactly) {
  const auto file = fresh_folder("arete_png") / "a.png";
  const auto rgb = noise(31, 17);
  write_png(file, 31, 17, rgb);
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  ASSERT_NE(png_image_begin_read_from_file(&image, file.c_str()), 0);
  EXPECT_EQ(image.width, 31U);
  EXPECT_EQ(image.height, 17U);
  image.format = PNG_FORMAT_RGB;
  std::vector<std::uint8_t> back(PNG_IMAGE_SIZE(image));
  ASSERT_NE(png_image_finish_read(&image, nullptr, back.data(), 0, nullptr), 0);
  EXPECT_EQ(back, rgb);
}

TEST(WritePng, AMissingFolderIsOneLineAndLeavesNothing) {
  const auto file = fresh_folder("arete_png_missing") / "no" / "a.png";
  try {
    write_png(file, 3, 3, noise(3, 3));
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::Io);
    EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos);
  }
}

TEST(WritePng, AFullDiskIsReported) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full";
  const auto link = fresh_folder("arete_png_full") / "a.png";
  std::filesystem::create_symlink("/dev/full", link);
  EXPECT_THROW(write_png(link, 200, 200, noise(200, 200)), Error);
  EXPECT_FALSE(std::filesystem::is_symlink(link));
}

bool has_ffmpeg() {
  return std::system("ffmpeg -version > /dev/null 2>&1") == 0;
}

TEST(VideoWriter, MakesAnMp4OfOddSizeWithAnAwkwardName) {
  if (!has_ffmpeg()) GTEST_SKIP() << "no ffmpeg";
  const auto file = fresh_folder("arete_video") / "a 'b' $(c) %d.mp4";
  VideoWriter writer(file, 35, 21, 30);
  for (int i = 0; i < 10; ++i) writer.add(noise(35, 21));
  writer.finish();
  std::ifstream in(file, std::ios::binary);
  std::string head(12, '\0');
  in.read(head.data(), 12);
  EXPECT_EQ(head.substr(4, 4), "ftyp");
}

TEST(VideoWriter, AnUnfinishedFileIsRemoved) {
  if (!has_ffmpeg()) GTEST_SKIP() << "no ffmpeg";
  const auto file = fresh_folder("arete_video_part") / "a.mp4";
  {
    VideoWriter writer(file, 64, 64, 30);
    for (int i = 0; i < 5; ++i) writer.add(noise(64, 64));
  }
  EXPECT_FALSE(std::filesystem::exists(file));
}

TEST(VideoWriter, AFailingFfmpegIsOneLineAndNoSignal) {
  if (!has_ffmpeg()) GTEST_SKIP() << "no ffmpeg";
  const auto file = fresh_folder("arete_video_missing") / "no" / "a.mp4";
  try {
    VideoWriter writer(file, 640, 480, 30);
    for (int i = 0; i < 50; ++i) writer.add(noise(640, 480));
    writer.finish();
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::Io);
    EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos);
  }
}

TEST(VideoWriter, AMissingFfmpegNamesThePackage) {
  const std::string path = std::getenv("PATH");
  setenv("PATH", "/nonexistent", 1);
  try {
    const VideoWriter writer("a.mp4", 64, 64, 30);
    ADD_FAILURE();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::Unsupported);
    EXPECT_NE(std::string(e.what()).find("install the package ffmpeg"), std::string::npos);
  }
  setenv("PATH", path.c_str(), 1);
}

}  // namespace
}  // namespace arete::render
