#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>

namespace arete::render {

/// Writes width*height*3 bytes, top row first, as PNG. Throws: Io; nothing is left then.
void write_png(const std::filesystem::path& file, int width, int height,
               std::span<const std::uint8_t> rgb);

/// Feeds frames to the ffmpeg program and makes an mp4 (H.264, yuv420p).
class VideoWriter {
 public:
  /// Throws: Unsupported when ffmpeg cannot be started, naming the package.
  VideoWriter(const std::filesystem::path& file, int width, int height, int frames_per_second);
  ~VideoWriter();  ///< an unfinished file is removed
  VideoWriter(const VideoWriter&) = delete;
  VideoWriter& operator=(const VideoWriter&) = delete;
  void add(std::span<const std::uint8_t> rgb);
  void finish();  ///< Throws: Io when ffmpeg failed.

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace arete::render
