#pragma once

#include <bit>
#include <cstdint>

namespace arete::lod::bintree {

/// An unsigned 16-bit float: 8 bits of exponent, 8 of mantissa, the upper half of a positive float
/// shifted by one bit. Codes order as their values do; kInfinite is the largest.
using Code = std::uint16_t;
inline constexpr Code kInfinite = 0xFF00;

/// The value of a code, metres. Requires: code <= kInfinite.
inline float value(Code code) {
  return std::bit_cast<float>(static_cast<std::uint32_t>(code) << 15U);
}

/// The least code whose value is at least x; at most 2^-8 of x above it. Requires: x >= 0.
inline Code code_up(double x) {
  const auto nearest = static_cast<float>(x);
  const std::uint32_t below = static_cast<double>(nearest) < x ? 1 : 0;
  constexpr std::uint32_t kRoundUp = (1U << 15U) - 1;
  return static_cast<Code>((std::bit_cast<std::uint32_t>(nearest) + below + kRoundUp) >> 15U);
}

/// What is stored of a vertex.
///
/// `delta`: bound on |drawn - true| in metres, at the posts of drawable cells in the triangles that
/// share the base edge which the vertex bisects, while they are drawn whole: flat triangles through
/// vertices rounded to float. It is at least the delta of every DAG child (saturated). With
/// incremental deltas it is the paper's: the distance from the edge's midpoint, saturated.
///
/// `radius`: value(radius) >= |v - c| + value(c.radius) for every DAG child c that has land,
/// distances in world metres: a sphere about the vertex that holds those of all its descendants.
///
/// A vertex *has land* when it or a DAG descendant is a post of a drawable cell; then so have all
/// its DAG ancestors. The records of the others are all zero: they are never refined, and no
/// sphere has to hold them. The centre and the corners have both codes infinite, always.
struct Record {
  std::int32_t count = 0;  ///< lattice height, z = offset + quantum * count; of holes: filled;
                           ///< beyond the grid: that of its edge
  Code delta = 0;
  Code radius = 0;
};
static_assert(sizeof(Record) == 8);

}  // namespace arete::lod::bintree
