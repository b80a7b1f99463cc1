#pragma once

#include <cstdint>

#include "arete/render/gl_object.h"
#include "arete/render/renderer.h"

namespace arete::render {

/// Hypsometric tint over [z_min, z_max]. Earth: valleys green, then ochre, rock and snow; blues
/// below 0 m where the range spans it. Other bodies: their own rock, no sea.
struct Tint {
  GlTexture texture;  ///< 1D, sRGB, lowest first
  float sea_level;    ///< share of the range that is below 0 m; -1 = no sea
};

inline constexpr int kTintTexels = 1024, kGrainSize = 256;
/// Of a tint (RGBA8) and the grain with its mipmaps (R8).
inline constexpr std::uint64_t kTintBytes =
    std::uint64_t{4} * kTintTexels + (std::uint64_t{4} * kGrainSize * kGrainSize - 1) / 3;

Tint make_tint(Body body, double z_min, double z_max);

/// Repeating R8 noise around 0.5 with mipmaps, the same on every machine.
GlTexture make_grain();

}  // namespace arete::render
