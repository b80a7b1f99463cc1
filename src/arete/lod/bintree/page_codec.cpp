#include "arete/lod/bintree/page_codec.h"

#include <array>
#include <cassert>
#include <cstdint>

#include "arete/lod/bintree/record_pages.h"

namespace arete::lod::bintree {
namespace {

constexpr std::size_t kCountBytes = sizeof(Record::count), kCodeBytes = sizeof(Code);

std::uint32_t zigzag(std::uint32_t difference) {
  return (difference << 1U) ^ (0U - (difference >> 31U));
}
std::uint32_t unzigzag(std::uint32_t code) {
  return (code >> 1U) ^ (0U - (code & 1U));
}

template <std::size_t kBytes, typename Value>
std::byte* put_planes(const std::array<Value, kPageRecords>& values, std::byte* to) {
  for (std::size_t b = 0; b < kBytes; ++b)
    for (const Value v : values) *to++ = static_cast<std::byte>(v >> (8 * b));
  return to;
}

template <std::size_t kBytes, typename Value>
const std::byte* take_planes(const std::byte* from, std::array<Value, kPageRecords>& values) {
  values.fill(0);
  for (std::size_t b = 0; b < kBytes; ++b)
    for (Value& v : values) v = static_cast<Value>(v | (static_cast<Value>(*from++) << (8 * b)));
  return from;
}

}  // namespace

void encode_page(std::span<const Record> records, std::vector<std::byte>& raw) {
  assert(records.size() == kPageRecords);
  std::array<std::uint32_t, kPageRecords> counts;
  std::array<Code, kPageRecords> deltas;
  std::array<Code, kPageRecords> radii;
  std::uint32_t last = 0;
  for (std::size_t i = 0; i < kPageRecords; ++i) {
    const auto count = static_cast<std::uint32_t>(records[i].count);
    counts[i] = zigzag(count - last);
    deltas[i] = records[i].delta;
    radii[i] = records[i].radius;
    last = count;
  }
  raw.resize(kRecordPageBytes);
  std::byte* to = put_planes<kCountBytes>(counts, raw.data());
  to = put_planes<kCodeBytes>(deltas, to);
  put_planes<kCodeBytes>(radii, to);
}

bool decode_page(std::span<const std::byte> raw, std::span<Record> records) {
  if (raw.size() != kRecordPageBytes || records.size() != kPageRecords) return false;
  std::array<std::uint32_t, kPageRecords> counts;
  std::array<Code, kPageRecords> deltas;
  std::array<Code, kPageRecords> radii;
  const std::byte* from = take_planes<kCountBytes>(raw.data(), counts);
  from = take_planes<kCodeBytes>(from, deltas);
  take_planes<kCodeBytes>(from, radii);
  std::uint32_t last = 0;
  for (std::size_t i = 0; i < kPageRecords; ++i) {
    last += unzigzag(counts[i]);
    records[i] = {static_cast<std::int32_t>(last), deltas[i], radii[i]};
  }
  return true;
}

}  // namespace arete::lod::bintree
