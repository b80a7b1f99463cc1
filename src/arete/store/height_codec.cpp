#include "arete/store/height_codec.h"

#include <algorithm>
#include <array>
#include <type_traits>

#include "arete/core/error.h"
#include "arete/store/bytes.h"

namespace arete::store {
namespace {

constexpr std::size_t kSide = kTilePosts;
constexpr std::size_t kValidBytes = (kTilePostCount + 7) / 8;

// Gradient predicts west + north - northwest, North the post above; the first row always by west.
enum Predictor : std::uint8_t { Gradient = 0, North = 1 };

struct TileHead {
  std::uint8_t predictor = Gradient;
  std::uint8_t planes = 0;     // 0, 1 or 2: residuals of 16 bits; 4: of 32; 0: all are zero
  std::uint8_t has_valid = 0;  // 1: a bit a post follows the planes, lowest bit first
  std::int32_t base = 0;       // the least count; residuals are of count - base
};

template <typename Io, typename Head>
void head_fields(Io& io, Head& h) {
  using Byte = std::conditional_t<std::is_const_v<Head>, const std::uint8_t, std::uint8_t>;
  Byte reserved = 0;
  io(h.predictor);
  io(h.planes);
  io(h.has_valid);
  io(reserved);
  io(h.base);
}

template <typename Word>
Word zigzag(Word r) {
  using Signed = std::make_signed_t<Word>;
  constexpr int kSignShift = sizeof(Word) * 8 - 1;
  return static_cast<Word>((r << 1) ^ static_cast<Word>(static_cast<Signed>(r) >> kSignShift));
}

template <typename Word>
Word unzigzag(Word z) {
  return static_cast<Word>((z >> 1) ^ static_cast<Word>(0U - (z & 1U)));
}

template <typename Word>
using Words = std::array<Word, kTilePostCount>;

// Residuals modulo 2^bits: whatever the predictor does, adding it back restores the word.
template <typename Word>
void predict(const Words<Word>& u, std::uint8_t predictor, Words<Word>& z) {
  z[0] = zigzag(u[0]);
  for (std::size_t c = 1; c < kSide; ++c) z[c] = zigzag(static_cast<Word>(u[c] - u[c - 1]));
  for (std::size_t r = 1; r < kSide; ++r) {
    const Word* row = &u[r * kSide];
    const Word* north = row - kSide;
    Word* out = &z[r * kSide];
    out[0] = zigzag(static_cast<Word>(row[0] - north[0]));
    if (predictor == North) {
      for (std::size_t c = 1; c < kSide; ++c) out[c] = zigzag(static_cast<Word>(row[c] - north[c]));
    } else {
      for (std::size_t c = 1; c < kSide; ++c)
        out[c] = zigzag(static_cast<Word>(row[c] - row[c - 1] - north[c] + north[c - 1]));
    }
  }
}

template <typename Word>
void restore(Words<Word>& z, std::uint8_t predictor) {
  for (Word& w : z) w = unzigzag(w);
  for (std::size_t c = 1; c < kSide; ++c) z[c] = static_cast<Word>(z[c] + z[c - 1]);
  for (std::size_t r = 1; r < kSide; ++r) {
    Word* row = &z[r * kSide];
    const Word* north = row - kSide;
    if (predictor == Gradient)
      for (std::size_t c = 1; c < kSide; ++c) row[c] = static_cast<Word>(row[c] + row[c - 1]);
    for (std::size_t c = 0; c < kSide; ++c) row[c] = static_cast<Word>(row[c] + north[c]);
  }
}

// The cheaper predictor by the sum of residuals over every eighth row.
template <typename Word>
std::uint8_t choose_predictor(const Words<Word>& u) {
  std::uint64_t gradient = 0;
  std::uint64_t north_only = 0;
  for (std::size_t r = 4; r < kSide; r += 8) {
    const Word* row = &u[r * kSide];
    const Word* north = row - kSide;
    for (std::size_t c = 1; c < kSide; ++c) {
      const auto d = static_cast<Word>(row[c] - north[c]);
      const auto west = static_cast<Word>(row[c - 1] - north[c - 1]);
      north_only += zigzag(d);
      gradient += zigzag(static_cast<Word>(d - west));
    }
  }
  return gradient <= north_only ? Gradient : North;
}

template <typename Word>
void split_planes(const Words<Word>& z, int planes, std::vector<std::byte>& raw) {
  for (int p = 0; p < planes; ++p) {
    const std::size_t at = raw.size();
    raw.resize(at + kTilePostCount);
    std::byte* out = raw.data() + at;
    for (std::size_t i = 0; i < kTilePostCount; ++i)
      out[i] = static_cast<std::byte>(z[i] >> (8 * p));
  }
}

template <typename Word>
void join_planes(std::span<const std::byte> planes, Words<Word>& z) {
  z.fill(0);
  for (std::size_t p = 0; p * kTilePostCount < planes.size(); ++p) {
    const std::byte* in = planes.data() + p * kTilePostCount;
    for (std::size_t i = 0; i < kTilePostCount; ++i)
      z[i] = static_cast<Word>(z[i] | static_cast<Word>(std::to_integer<Word>(in[i]) << (8 * p)));
  }
}

int planes_needed(const Words<std::uint16_t>& z) {
  std::uint16_t all = 0;
  for (const std::uint16_t w : z) all = static_cast<std::uint16_t>(all | w);
  return all == 0 ? 0 : all < 256 ? 1 : 2;
}

int planes_needed(const Words<std::uint32_t>&) {
  return 4;
}

template <typename Word>
void encode_words(std::span<const std::int32_t> counts, TileHead head,
                  std::vector<std::byte>& raw) {
  thread_local Words<Word> u, z;
  const auto base = static_cast<std::uint32_t>(head.base);
  for (std::size_t i = 0; i < kTilePostCount; ++i)
    u[i] = static_cast<Word>(static_cast<std::uint32_t>(counts[i]) - base);
  head.predictor = choose_predictor(u);
  predict(u, head.predictor, z);
  head.planes = static_cast<std::uint8_t>(planes_needed(z));
  ByteWriter writer(raw);
  head_fields(writer, head);
  split_planes(z, head.planes, raw);
}

template <typename Word>
void decode_words(std::span<const std::byte> planes, const TileHead& head,
                  std::vector<std::int32_t>& counts) {
  thread_local Words<Word> z;
  join_planes(planes, z);
  restore(z, head.predictor);
  const auto base = static_cast<std::uint32_t>(head.base);
  counts.resize(kTilePostCount);
  for (std::size_t i = 0; i < kTilePostCount; ++i)
    counts[i] = static_cast<std::int32_t>(base + z[i]);
}

void append_valid(std::span<const std::uint8_t> valid, std::vector<std::byte>& raw) {
  const std::size_t at = raw.size();
  raw.resize(at + kValidBytes);
  for (std::size_t i = 0; i < valid.size(); ++i)
    raw[at + i / 8] |= static_cast<std::byte>((valid[i] != 0 ? 1U : 0U) << (i % 8));
}

void take_valid(std::span<const std::byte> bits, std::vector<std::uint8_t>& valid) {
  valid.resize(bits.empty() ? 0 : kTilePostCount);
  for (std::size_t i = 0; i < valid.size(); ++i)
    valid[i] = std::to_integer<std::uint8_t>((bits[i / 8] >> (i % 8)) & std::byte{1});
}

}  // namespace

void encode_tile(std::span<const std::int32_t> counts, std::span<const std::uint8_t> valid,
                 std::vector<std::byte>& raw) {
  raw.clear();
  std::int32_t least = counts[0];
  std::int32_t most = counts[0];
  for (const std::int32_t c : counts) {
    least = std::min(least, c);
    most = std::max(most, c);
  }
  TileHead head;
  head.base = least;
  head.has_valid = valid.empty() ? 0 : 1;
  if (static_cast<std::int64_t>(most) - least <= 0xFFFF)
    encode_words<std::uint16_t>(counts, head, raw);
  else
    encode_words<std::uint32_t>(counts, head, raw);
  if (head.has_valid != 0) append_valid(valid, raw);
}

void decode_tile(std::span<const std::byte> raw, HeightTile& tile) {
  ByteReader reader(raw);
  TileHead head;
  head_fields(reader, head);
  const bool known =
      head.predictor <= North && head.has_valid <= 1 && (head.planes <= 2 || head.planes == 4);
  const auto planes = reader.bytes(head.planes * kTilePostCount);
  const auto bits = reader.bytes(head.has_valid * kValidBytes);
  if (!known || !reader.ok() || reader.left() != 0)
    throw Error(ErrorCode::Corrupt, "height tile: not in a known coding: rebuild the store");
  if (head.planes == 4)
    decode_words<std::uint32_t>(planes, head, tile.counts);
  else
    decode_words<std::uint16_t>(planes, head, tile.counts);
  take_valid(bits, tile.valid);
}

}  // namespace arete::store
