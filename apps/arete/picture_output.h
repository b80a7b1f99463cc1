#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>

#include "quantities.h"

namespace arete::app {

enum class PictureKind { Still, Video, Numbered };

/// .png, .mp4, or a directory (no extension, or one that exists). Throws: Usage for others.
PictureKind picture_kind(const std::filesystem::path& output);

/// Where rendered frames go. Destroyed before finish(), it leaves nothing behind.
class PictureOutput {
 public:
  virtual ~PictureOutput() = default;
  /// size.width * size.height * 3 bytes, top row first.
  virtual void add(std::span<const std::uint8_t> rgb) = 0;
  virtual void finish() = 0;
};

/// Throws: Usage for a size that the format cannot take; Io, Unsupported.
std::unique_ptr<PictureOutput> open_output(const std::filesystem::path& output, FrameSize size,
                                           int frames_per_second);

}  // namespace arete::app
