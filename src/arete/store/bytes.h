#pragma once

#include <bit>
#include <concepts>
#include <cstddef>
#include <cstring>
#include <span>
#include <vector>

namespace arete::store {

static_assert(std::endian::native == std::endian::little,
              "the store is little-endian and is read by memcpy");

/// Appends numbers to a byte vector, little-endian.
class ByteWriter {
 public:
  explicit ByteWriter(std::vector<std::byte>& out) : out_(out) {}
  template <typename T>
  requires std::integral<T> || std::floating_point<T>
  void operator()(const T& value) { bytes(std::as_bytes(std::span(&value, 1))); }
  void bytes(std::span<const std::byte> in) { out_.insert(out_.end(), in.begin(), in.end()); }

 private:
  std::vector<std::byte>& out_;
};

/// Takes numbers from bytes, little-endian. Past the end it gives zeros and ok() turns false.
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::byte> in) : in_(in) {}
  template <typename T>
  requires std::integral<T> || std::floating_point<T>
  void operator()(T& value) {
    const auto from = bytes(sizeof(T));
    value = T{};
    if (!from.empty()) std::memcpy(&value, from.data(), sizeof(T));
  }
  /// The next n bytes; empty when fewer are left.
  std::span<const std::byte> bytes(std::size_t n) {
    if (n > in_.size()) {
      ok_ = false;
      in_ = {};
      return {};
    }
    const auto taken = in_.first(n);
    in_ = in_.subspan(n);
    return taken;
  }
  std::size_t left() const { return in_.size(); }
  bool ok() const { return ok_; }

 private:
  std::span<const std::byte> in_;
  bool ok_ = true;
};

}  // namespace arete::store
