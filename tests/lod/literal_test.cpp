// Wagner's article to the letter, and de Boer's: what they keep and what they do not.
#include <algorithm>
#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "arete/core/error.h"
#include "arete/lod/uniform_field.h"
#include "arete/mesh/surface.h"
#include "arete/proof/residual.h"

#include "lod/built_terrain.h"
#include "lod/switch_jumps.h"
#include "lod/variants.h"

namespace arete::lod {
namespace {

class Literal : public testing::Test {
 protected:
  std::unique_ptr<Engine> open(std::string_view name) const {
    for (const Variant& variant : variants()) {
      if (variant.name == name) return variant.open(*opened_, "17");
    }
    return nullptr;
  }

  SwitchJumps jumps(std::string_view name) const {
    const auto engine = open(name);
    SwitchWatch watch(*engine, reference_, 4);
    SwitchJumps all;
    for (int k = 0; k < 6; ++k) {
      const double from = 0.1 + 0.13 * k;
      const SwitchJumps found = watch.measure(flight_view, from, from + 8e-3, 6);
      all.switches += found.switches;
      all.max_px = std::max(all.max_px, found.max_px);
    }
    return all;
  }

  BuiltTerrain terrain_{rough_dem(257, 193, 1, 0), {{"patch", "17"}}};
  std::unique_ptr<store::Terrain> opened_ = terrain_.open();
  proof::Reference reference_{terrain_.dem(), 2};
};

// METHODS 7.8(4): exact mode does not jump at any switch, literal mode does.
TEST_F(Literal, JumpsAtSwitchesAndExactModeDoesNot) {
  const SwitchJumps exact = jumps("geomipmap");
  EXPECT_GT(exact.switches, 10);
  EXPECT_LT(exact.max_px, 2e-3);
  const SwitchJumps literal = jumps("geomipmap_literal");
  EXPECT_GT(literal.switches, 10);
  EXPECT_GT(literal.max_px, 0.1);
}

// Without a morph whole patches jump.
TEST_F(Literal, DeboerJumpsAtSwitches) {
  const SwitchJumps plain = jumps("deboer");
  EXPECT_GT(plain.switches, 10);
  EXPECT_GT(plain.max_px, 0.5);
}

// W4: a vertex of smaller error but nearer projects larger, so the tolerance is overshot; the bound
// that the list carries is not.
TEST_F(Literal, OvershootsTheToleranceButNotItsBound) {
  for (const char* name : {"geomipmap_literal", "deboer", "deboer_trilinear"}) {
    SCOPED_TRACE(name);
    const auto engine = open(name);
    EXPECT_TRUE(std::isinf(engine->claims({}).error_px));
    double worst = 0;
    DrawList list;
    mesh::Surface surface;
    for (int k = 0; k < 20; ++k) {
      const View view = flight_view(k / 20.0);
      engine->refine(view, {.tolerance_px = 2}, list);
      mesh::flatten(list, *engine, surface);
      const double px = proof::measure_residuals(surface, reference_, view, 2).px.max_px();
      EXPECT_LE(px, list.stats.achieved_error_px);
      worst = std::max(worst, px);
    }
    EXPECT_GT(worst, 2);
  }
}

TEST(CoarsestLevel, IsTheInverseOfTheErrors) {
  const auto errors = [](int l) {
    return std::array<double, 5>{0, 1, 2, 4, 8}[static_cast<std::size_t>(l)];
  };
  EXPECT_EQ(coarsest_level(4, 8, errors), 4);
  EXPECT_EQ(coarsest_level(4, 100, errors), 4);
  EXPECT_EQ(coarsest_level(4, 0, errors), 0);
  EXPECT_EQ(coarsest_level(4, 0.5, errors), 0.5);
  EXPECT_EQ(coarsest_level(4, 3, errors), 2.5);
  EXPECT_EQ(coarsest_level(4, 4, errors), 3);
  EXPECT_LT(coarsest_level(4, std::nextafter(4.0, 0.0), errors), 3);
  // The coarsest level below the bound, although a finer one is above it (W6).
  const auto odd = [](int l) {
    return std::array<double, 5>{0, 5, 6, 1, 8}[static_cast<std::size_t>(l)];
  };
  EXPECT_EQ(std::floor(coarsest_level(4, 2, odd)), 3);
}

TEST(LiteralStore, SaysWhatToBuildWhenVerticesAreMissing) {
  const BuiltTerrain built(rough_dem(33, 33, 3, 0), {{"patch", "17"}});
  const auto terrain = built.open();
  EXPECT_THROW(find_engine("deboer").open(*terrain, {{"patch", "129"}}), Error);
  EXPECT_THROW(find_engine("deboer").open(*terrain, {{"trilinear", "yes"}}), Error);
  EXPECT_THROW(find_engine("geomipmap").open(*terrain, {{"literal", "1"}}), Error);
  try {
    find_engine("deboer").open(*terrain, {{"patch", "9"}});
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::NotFound);
  }
}

}  // namespace
}  // namespace arete::lod
