#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

struct XXH3_state_s;

namespace arete::store {

/// 128-bit content hash: guards against accidents, not against attackers.
struct Hash128 {
  std::uint64_t low = 0, high = 0;
  std::string hex() const;  ///< 32 digits, high half first
  friend bool operator==(const Hash128&, const Hash128&) = default;
};

/// xxh3-64.
std::uint64_t hash64(std::span<const std::byte> bytes, std::uint64_t seed = 0);
std::uint64_t hash64(std::string_view text);
/// xxh3-128.
Hash128 hash128(std::span<const std::byte> bytes);
Hash128 hash128(std::string_view text);

/// xxh3-64 of bytes that come in pieces.
class Hasher {
 public:
  Hasher();
  ~Hasher();
  Hasher(const Hasher&) = delete;
  Hasher& operator=(const Hasher&) = delete;
  void add(std::span<const std::byte> bytes);
  std::uint64_t digest() const;

 private:
  XXH3_state_s* state_;
};

}  // namespace arete::store
