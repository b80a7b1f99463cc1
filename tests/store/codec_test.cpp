#include <algorithm>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "arete/core/error.h"
#include "arete/store/height_codec.h"
#include "arete/store/height_patch.h"
#include "arete/store/lattice.h"
#include "arete/store/raster_pyramid.h"

namespace arete::store {
namespace {

std::vector<std::int32_t> random_counts(std::mt19937& random, std::int64_t least,
                                        std::int64_t most) {
  std::uniform_int_distribution<std::int64_t> count(least, most);
  std::vector<std::int32_t> counts(kTilePostCount);
  for (std::int32_t& c : counts) c = static_cast<std::int32_t>(count(random));
  return counts;
}

TEST(HeightCodec, AnyCountsComeBack) {
  constexpr std::int64_t kLeast = std::numeric_limits<std::int32_t>::min();
  constexpr std::int64_t kMost = std::numeric_limits<std::int32_t>::max();
  const std::pair<std::int64_t, std::int64_t> ranges[] = {{0, 0},
                                                          {-5, -5},
                                                          {7, 8},
                                                          {0, 255},
                                                          {-300, 300},
                                                          {0, 65535},
                                                          {0, 65536},
                                                          {-32768, 32767},
                                                          {-40000, 40000},
                                                          {kLeast, kMost},
                                                          {kMost, kMost},
                                                          {kLeast, kLeast},
                                                          {kLeast, kLeast + 65535},
                                                          {kMost - 65535, kMost}};
  std::mt19937 random(4);
  for (const auto& [least, most] : ranges) {
    SCOPED_TRACE(least);
    const auto counts = random_counts(random, least, most);
    std::vector<std::uint8_t> valid(kTilePostCount);
    for (std::uint8_t& v : valid) v = static_cast<std::uint8_t>(random() & 1U);
    std::vector<std::byte> raw;
    HeightTile tile;
    encode_tile(counts, {}, raw);
    decode_tile(raw, tile);
    EXPECT_EQ(tile.counts, counts);
    EXPECT_TRUE(tile.valid.empty());
    encode_tile(counts, valid, raw);
    decode_tile(raw, tile);
    EXPECT_EQ(tile.counts, counts);
    EXPECT_EQ(tile.valid, valid);
  }
}

TEST(HeightCodec, WrongLengthsAndCodingsAreRefused) {
  std::mt19937 random(4);
  std::vector<std::byte> raw;
  encode_tile(random_counts(random, -3, 900), {}, raw);
  HeightTile tile;
  for (const std::size_t n : {std::size_t{0}, std::size_t{7}, raw.size() - 1})
    EXPECT_THROW(decode_tile(std::span(raw).first(n), tile), Error);
  for (const std::size_t at : {std::size_t{0}, std::size_t{1}, std::size_t{2}}) {
    auto bad = raw;
    bad[at] = std::byte{9};
    EXPECT_THROW(decode_tile(bad, tile), Error) << at;
  }
}

TEST(Lattice, RoundsToTheNearestAndCountsErrors) {
  const std::vector<float> z{0.0F, 1.26F, -1.26F, std::numeric_limits<float>::quiet_NaN(), 7.5F};
  std::vector<std::int32_t> counts(z.size());
  RowStats stats;
  ASSERT_TRUE(quantize_row({0.5, 0}, z, counts, stats));
  EXPECT_EQ(counts, (std::vector<std::int32_t>{0, 3, -3, kAbsent, 15}));
  EXPECT_EQ(stats.valid, 4);
  EXPECT_EQ(stats.count_min, -3);
  EXPECT_EQ(stats.count_max, 15);
  EXPECT_FLOAT_EQ(stats.max_error_m, 0.24F);
  EXPECT_FALSE(quantize_row({1e-9, 0}, z, counts, stats));
}

TEST(TexelCodec, AnyTexelsComeBack) {
  std::mt19937 random(8);
  for (int channels = 1; channels <= 4; ++channels) {
    Texels texels{16, channels,
                  std::vector<std::uint8_t>(static_cast<std::size_t>(256 * channels))};
    for (std::uint8_t& b : texels.bytes) b = static_cast<std::uint8_t>(random());
    std::vector<std::byte> raw;
    encode_texels(texels, raw);
    Texels back{16, channels, std::vector<std::uint8_t>(texels.bytes.size())};
    decode_texels(raw, back);
    EXPECT_EQ(back.bytes, texels.bytes);
  }
}

}  // namespace
}  // namespace arete::store
