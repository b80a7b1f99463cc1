#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>

#include "quantities.h"

namespace arete::app {

enum class PictureKind { kStill, kVideo, kNumbered };

/// .png, .mp4, or a directory (no extension, or one that exists). Throws: kUsage for others.
PictureKind picture_kind(const std::filesystem::path& output);

/// Where rendered frames go. Destroyed before finish(), it leaves nothing behind.
class PictureOutput {
 public:
  virtual ~PictureOutput() = default;
  /// size.width * size.height * 3 bytes, top row first.
  virtual void add(std::span<const std::uint8_t> rgb) = 0;
  virtual void finish() = 0;
};

/// Throws: kUsage for a size that the format cannot take; kIo, kUnsupported.
std::unique_ptr<PictureOutput> open_output(const std::filesystem::path& output, FrameSize size,
                                           int frames_per_second);

}  // namespace arete::app
