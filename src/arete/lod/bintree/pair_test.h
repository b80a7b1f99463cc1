#pragma once

#include <bit>
#include <cstdint>

#include "arete/lod/bintree/ground.h"

namespace arete::lod::bintree {

/// Ground::ball and Criterion::selected of two vertices at once, a lane of vector registers each.
/// The same operations in the same order: so the answers are the same, bit by bit.
class PairTest {
 public:
  PairTest(const Ground& ground, const Criterion& criterion)
      : offset_(both(ground.offset_m())),
        quantum_(both(ground.quantum_m())),
        eye_{both(criterion.eye().x), both(criterion.eye().y), both(criterion.eye().z)},
        nu_(both(criterion.nu())),
        floor_(both(criterion.floor_m())) {
    for (std::size_t i = 0; i < 6; ++i) affine_[i] = both(ground.world_from_post().m[i]);
  }

  /// Heights as drawn and answers of vertices a and b.
  struct Answers {
    float z_a, z_b;
    bool a, b;
  };
  Answers operator()(Post post_a, const Record& a, Post post_b, const Record& b) const {
    const Fours posts = fours(post_a, post_b);
    const Fours records = fours(a, b);
    const Fours codes = __builtin_shufflevector(records, records, 1, 3, 1, 3);
    const Pair col = doubles(__builtin_shufflevector(posts, posts, 0, 2, 0, 2));
    const Pair row = doubles(__builtin_shufflevector(posts, posts, 1, 3, 1, 3));
    const Pair z =
        offset_ + quantum_ * doubles(__builtin_shufflevector(records, records, 0, 2, 0, 2));
    const Pair dx = affine_[0] * col + affine_[1] * row + affine_[2] - eye_[0];
    const Pair dy = affine_[3] * col + affine_[4] * row + affine_[5] - eye_[1];
    const Pair dz = z - eye_[2];
    const Pair delta = values((codes & 0xFFFF) << 15);
    const Pair radius = values((codes >> 1) & 0x7FFF8000);
    const Pair reach = nu_ * delta + radius;
    const auto selected = (delta > floor_) & (dx * dx + dy * dy + dz * dz < reach * reach);
    return {static_cast<float>(z[0]), static_cast<float>(z[1]), selected[0] != 0, selected[1] != 0};
  }

 private:
  using Pair [[gnu::vector_size(16)]] = double;
  using Longs [[gnu::vector_size(16)]] = std::int64_t;
  using Fours [[gnu::vector_size(16)]] = std::int32_t;

  static_assert(std::endian::native == std::endian::little);  // delta is the low half of its word

  static Pair both(double x) { return Pair{x, x}; }
  /// Two Posts or Records of two words each.
  template <typename TwoWords>
  static Fours fours(const TwoWords& a, const TwoWords& b) {
    return std::bit_cast<Fours>(
        Longs{std::bit_cast<std::int64_t>(a), std::bit_cast<std::int64_t>(b)});
  }
  static Pair doubles(Fours v) {
    return Pair{static_cast<double>(v[0]), static_cast<double>(v[1])};
  }
  static Pair values(Fours bits) {
    return Pair{std::bit_cast<float>(std::int32_t{bits[0]}),
                std::bit_cast<float>(std::int32_t{bits[1]})};
  }

  Pair affine_[6], offset_, quantum_, eye_[3], nu_, floor_;
};

}  // namespace arete::lod::bintree
