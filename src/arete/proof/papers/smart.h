#pragma once

#include <array>

#include "arete/proof/papers/paper.h"

namespace arete::proof::smart {

inline constexpr std::array<std::string_view, 2> kMethods{"soar", "smart"};

/// Section 5 of [BaoPajarolaShafae2004] on the path given: 800 x 600, tolerances 1, 2, 4 and 8 px,
/// flown at the three speeds that change 0.61, 1.36 and 5.29 % of SOAR's triangles a frame. Every
/// run flies ten stretches, evenly along the path, whose first frame (a teleport) is not counted.
/// Errors are angles, as in the paper (_upright: bounds in pixels, our default); _literal: SMART as
/// printed, but for ticks rounded up, without which it draws other triangles than SOAR.
/// Throws: NotFound when the store lacks a method's segment; what progress throws.
std::vector<PaperRow> run(const store::Terrain& terrain, const scene::Path& path,
                          const PaperOptions& options);

}  // namespace arete::proof::smart
