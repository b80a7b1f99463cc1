#include "arete/raster/dem_file.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "arete/core/error.h"
#include "arete/raster/encoding.h"

namespace arete::raster {
namespace {

constexpr std::int64_t kSurveyPosts = 4 << 20;

// Whole block rows, near 256 rows at most. A single block row may take four times the buffer: each
// part of it that is read alone costs decoding the whole.
int pick_chunk_rows(const DemFile::Parts& parts, int block_rows, std::size_t row_bytes) {
  const auto fitting = [&](std::size_t bytes) {
    return static_cast<int>(std::clamp<std::size_t>(bytes / row_bytes, 1, 1U << 24U));
  };
  const int block = std::clamp(block_rows, 1, parts.rows);
  const int most = fitting(parts.buffer_bytes);
  if (block > most) return std::min(block, fitting(4 * parts.buffer_bytes));
  return std::min(parts.rows, block * std::max(1, std::min(256, most) / block));
}

// What lies under the mask is anything: a valid sample instead, so that no note is taken of it.
void repeat_valid(std::span<const std::byte> mask, std::size_t sample_bytes, std::byte* samples) {
  const auto valid = std::ranges::find_if(mask, [](std::byte b) { return b != std::byte{0}; });
  const auto first = static_cast<std::size_t>(valid - mask.begin());
  for (std::size_t i = 0; i < mask.size(); ++i) {
    if (mask[i] != std::byte{0}) continue;
    if (valid == mask.end()) {
      std::fill_n(samples + i * sample_bytes, sample_bytes, std::byte{0});
    } else {
      std::copy_n(samples + first * sample_bytes, sample_bytes, samples + i * sample_bytes);
    }
  }
}

}  // namespace

std::size_t SampleFormat::sample_bytes() const {
  return static_cast<std::size_t>(bands) *
         static_cast<std::size_t>(GDALGetDataTypeSizeBytes(rule.type));
}

DemFile::DemFile(Parts parts) : parts_(std::move(parts)) {
  row_bytes_ = static_cast<std::size_t>(parts_.cols) * parts_.format.sample_bytes();
  block_rows_ = parts_.samples->block_rows();
  held_row_bytes_ =
      row_bytes_ + (parts_.samples->masked() ? static_cast<std::size_t>(parts_.cols) : 0);
  chunk_rows_ = pick_chunk_rows(parts_, block_rows_, held_row_bytes_);
  counted_.resize(static_cast<std::size_t>(parts_.rows));
  survey();
}

Georef DemFile::georef() const {
  Georef georef = parts_.placement.georef;
  for (std::string& note : describe(tally_)) georef.notes.push_back(std::move(note));
  return georef;
}

HeightLattice DemFile::lattice() const {
  if (parts_.format.encoding == Encoding::None) return parts_.format.rule.lattice();
  return encoding_lattice(parts_.format.encoding, parts_.format.rule);
}

std::string DemFile::description() const {
  return fmt::format("{} ({} x {}, {})", parts_.name, parts_.cols, parts_.rows, parts_.driver);
}

void DemFile::release() {
  loaded_rows_ = 0;
  buffer_ = {};
  mask_ = {};
  parts_.samples.reset();
}

void DemFile::read_in_chunks_of(std::size_t bytes) {
  release();
  parts_.buffer_bytes = bytes;
  chunk_rows_ = pick_chunk_rows(parts_, block_rows_, held_row_bytes_);
}

void DemFile::load_chunk_of(int source_row) {
  if (source_row >= loaded_first_ && source_row < loaded_first_ + loaded_rows_) return;
  const int first = source_row / chunk_rows_ * chunk_rows_;
  loaded_rows_ = 0;
  if (!parts_.samples) parts_.samples = parts_.reopen();
  try {
    read_rows(first, std::min(chunk_rows_, parts_.rows - first));
  } catch (const Error&) {
    // A damaged chunk may still hold this row.
    read_rows(source_row, 1);
  }
}

void DemFile::read_rows(int first, int count) {
  buffer_.resize(row_bytes_ * static_cast<std::size_t>(chunk_rows_));
  parts_.samples->read(first, count, buffer_.data());
  if (parts_.samples->masked()) {
    mask_.resize(static_cast<std::size_t>(parts_.cols) * static_cast<std::size_t>(chunk_rows_));
    parts_.samples->read_mask(first, count, mask_.data());
  }
  loaded_first_ = first;
  loaded_rows_ = count;
}

void DemFile::decode_row(int source_row, std::span<float> row) {
  const SampleFormat& format = parts_.format;
  const auto line = static_cast<std::size_t>(source_row - loaded_first_);
  std::byte* const samples = buffer_.data() + line * row_bytes_;
  const auto mask = mask_.empty()
                        ? std::span<const std::byte>()
                        : std::span<const std::byte>(mask_).subspan(line * row.size(), row.size());
  Tally again;
  auto counted = counted_[static_cast<std::size_t>(source_row)];
  Tally& tally = counted ? again : tally_;
  repeat_valid(mask, format.sample_bytes(), samples);
  if (format.encoding == Encoding::None) {
    decode(format.rule, samples, row, tally);
  } else {
    decode_colours(format.encoding, format.bands, format.rule, samples, row);
  }
  for (std::size_t i = 0; i < mask.size(); ++i) {
    if (mask[i] == std::byte{0}) row[i] = std::numeric_limits<float>::quiet_NaN();
  }
  counted = true;
}

void DemFile::read_row(int r, std::span<float> row) {
  const int source_row = parts_.placement.flip_rows ? parts_.rows - 1 - r : r;
  load_chunk_of(source_row);
  decode_row(source_row, row);
  if (parts_.placement.flip_cols) std::reverse(row.begin(), row.end());
}

// A look at a few rows, so that the notes are there before all rows are read. Damage is not told
// here: read_row will tell it.
void DemFile::survey() {
  const std::int64_t chunk_posts = std::int64_t{parts_.cols} * chunk_rows_;
  const auto places = static_cast<int>(std::clamp<std::int64_t>(kSurveyPosts / chunk_posts, 1, 8));
  std::vector<float> row(static_cast<std::size_t>(parts_.cols));
  try {
    for (int k = places; k-- > 0;) {
      load_chunk_of(static_cast<int>(std::int64_t{parts_.rows - 1} * k / places));
      for (int r = 0; r < std::min(8, loaded_rows_); ++r) {
        decode_row(loaded_first_ + r * loaded_rows_ / std::min(8, loaded_rows_), row);
      }
    }
  } catch (const Error&) {
    release();
  }
}

}  // namespace arete::raster
