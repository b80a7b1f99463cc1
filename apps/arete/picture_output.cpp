#include "picture_output.h"

#include <vector>

#include <fmt/format.h>

#include "arete/core/error.h"
#include "arete/render/picture.h"

#include "unfinished.h"

namespace arete::app {
namespace {

namespace fs = std::filesystem;

class Still : public PictureOutput {
 public:
  Still(fs::path file, FrameSize size) : file_(std::move(file)), size_(size) {}
  void add(std::span<const std::uint8_t> rgb) override { rgb_.assign(rgb.begin(), rgb.end()); }
  void finish() override { render::write_png(file_, size_.width, size_.height, rgb_); }

 private:
  fs::path file_;
  FrameSize size_;
  std::vector<std::uint8_t> rgb_;
};

class Video : public PictureOutput {
 public:
  Video(const fs::path& file, FrameSize size, int frames_per_second)
      : writer_(file, size.width, size.height, frames_per_second) {}
  void add(std::span<const std::uint8_t> rgb) override { writer_.add(rgb); }
  void finish() override { writer_.finish(); }

 private:
  render::VideoWriter writer_;
};

class Numbered : public PictureOutput {
 public:
  Numbered(fs::path directory, FrameSize size) : directory_(std::move(directory)), size_(size) {
    unfinished_.add_directory(directory_);
  }
  void add(std::span<const std::uint8_t> rgb) override {
    const fs::path file = directory_ / fmt::format("{:06}.png", count_++);
    render::write_png(file, size_.width, size_.height, rgb);
    unfinished_.add(file);
  }
  void finish() override { unfinished_.finish(); }

 private:
  fs::path directory_;
  FrameSize size_;
  int count_ = 0;
  Unfinished unfinished_;
};

}  // namespace

PictureKind picture_kind(const fs::path& output) {
  if (output.extension() == ".png") {
    return PictureKind::Still;
  }
  if (output.extension() == ".mp4") {
    return PictureKind::Video;
  }
  if (output.extension().empty() || fs::is_directory(output)) {
    return PictureKind::Numbered;
  }
  throw Error(ErrorCode::Usage,
              fmt::format("{}: unknown kind of picture: name a .png, a .mp4 or a directory",
                          output.string()));
}

std::unique_ptr<PictureOutput> open_output(const fs::path& output, FrameSize size,
                                           int frames_per_second) {
  switch (picture_kind(output)) {
    case PictureKind::Still:
      return std::make_unique<Still>(output, size);
    case PictureKind::Numbered:
      return std::make_unique<Numbered>(output, size);
    case PictureKind::Video:
      break;
  }
  if (size.width % 2 != 0 || size.height % 2 != 0) {
    throw Error(ErrorCode::Usage, fmt::format("--size {}x{}: odd: a video needs even sides",
                                              size.width, size.height));
  }
  return std::make_unique<Video>(output, size, frames_per_second);
}

}  // namespace arete::app
