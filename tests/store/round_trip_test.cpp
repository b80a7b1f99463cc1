#include <cmath>
#include <random>
#include <tuple>

#include "arete/store/terrain.h"

#include "store/store_fixture.h"

namespace arete::store {
namespace {

// True where one of the (up to four) cells around the post is drawable.
bool is_drawn(const Heightfield& field, Post p) {
  for (int dr = -1; dr <= 0; ++dr)
    for (int dc = -1; dc <= 0; ++dc) {
      const Post cell{p.col + dc, p.row + dr};
      const bool inside = cell.col >= 0 && cell.row >= 0 && cell.col + 1 < field.cols() &&
                          cell.row + 1 < field.rows();
      if (inside && field.drawable(cell)) return true;
    }
  return false;
}

std::uint64_t count_drawable(const Heightfield& field) {
  std::uint64_t cells = 0;
  for (int r = 0; r + 1 < field.rows(); ++r)
    for (int c = 0; c + 1 < field.cols(); ++c) cells += field.drawable({c, r}) ? 1 : 0;
  return cells;
}

// The first post whose stored height is not the source's within `tolerance`, or where data appears
// from nowhere or is lost from a drawable cell; nothing when all agree.
std::string first_difference(const Heightfield& field, HeightSource& stored, double tolerance) {
  std::vector<float> row(static_cast<std::size_t>(field.cols()));
  for (int r = 0; r < field.rows(); ++r) {
    stored.read_row(r, row);
    for (int c = 0; c < field.cols(); ++c) {
      const float is = row[static_cast<std::size_t>(c)];
      const Post p{c, r};
      const bool lost = std::isnan(is) && is_drawn(field, p);
      const bool invented = !std::isnan(is) && !std::isfinite(field[p]);
      const bool moved =
          !std::isnan(is) && !invented && std::abs(static_cast<double>(is) - field[p]) > tolerance;
      if (lost || invented || moved)
        return "post " + std::to_string(c) + ", " + std::to_string(r) + ": " + std::to_string(is) +
               " for " + std::to_string(field[p]);
    }
  }
  return "";
}

// Every post of every level against the level-0 post that it must be.
void expect_levels_subsample(const Terrain& terrain) {
  const Manifest& m = terrain.manifest();
  const auto level0 = [&](int col, int row) -> std::int32_t {
    const auto x = static_cast<std::uint32_t>(std::min(col / kTileCells, terrain.tiles_x(0) - 1));
    const auto y = static_cast<std::uint32_t>(std::min(row / kTileCells, terrain.tiles_y(0) - 1));
    const auto tile = terrain.heights({0, x, y}, Fetch::Wait);
    if (!tile) return std::numeric_limits<std::int32_t>::min();
    const auto i = (row - static_cast<int>(y) * kTileCells) * kTilePosts + col -
                   static_cast<int>(x) * kTileCells;
    return tile->counts[static_cast<std::size_t>(i)];
  };
  for (int level = 1; level < terrain.levels(); ++level)
    for (int y = 0; y < terrain.tiles_y(level); ++y)
      for (int x = 0; x < terrain.tiles_x(level); ++x) {
        const TileId id{static_cast<std::uint32_t>(level), static_cast<std::uint32_t>(x),
                        static_cast<std::uint32_t>(y)};
        const auto tile = terrain.heights(id, Fetch::Wait);
        if (!tile) continue;
        for (int r = 0; r < kTilePosts; r += 3)
          for (int c = 0; c < kTilePosts; c += 3) {
            const int col = (x * kTileCells + c) << level;
            const int row = (y * kTileCells + r) << level;
            const std::int32_t want = level0(std::min(col, m.cols - 1), std::min(row, m.rows - 1));
            if (want == std::numeric_limits<std::int32_t>::min()) continue;
            ASSERT_EQ(tile->counts[static_cast<std::size_t>(r * kTilePosts + c)], want)
                << "level " << level << " post " << col << ", " << row;
            if (col >= m.cols || row >= m.rows) {
              ASSERT_FALSE(tile->is_valid(c, r));
            }
          }
      }
}

class RoundTrip : public testing::TestWithParam<std::tuple<int, int, int>> {};

TEST_P(RoundTrip, IntegersComeBackAsTheyWere) {
  const auto [cols, rows, holes] = GetParam();
  Heightfield field = make_hills(cols, rows, 7);
  punch_holes(field, holes, 11);
  TemporaryFolder folder;
  const auto terrain = Terrain::open(build_store(folder, field));
  EXPECT_EQ(first_difference(field, *terrain->height_source(), 0), "");
  EXPECT_EQ(terrain->manifest().max_store_error_m, 0);
  EXPECT_EQ(terrain->manifest().drawable_cells, count_drawable(field));
  expect_levels_subsample(*terrain);
}

INSTANTIATE_TEST_SUITE_P(Shapes, RoundTrip,
                         testing::Values(std::tuple{1, 1, 0}, std::tuple{1, 300, 0},
                                         std::tuple{300, 1, 0}, std::tuple{2, 2, 0},
                                         std::tuple{129, 129, 0}, std::tuple{130, 130, 0},
                                         std::tuple{128, 128, 0}, std::tuple{257, 3, 0},
                                         std::tuple{3, 257, 0}, std::tuple{700, 515, 0},
                                         std::tuple{700, 515, 3}, std::tuple{400, 640, 8},
                                         std::tuple{520, 130, 60}, std::tuple{385, 385, 200}));

TEST(RoundTripTest, NothingButNodataBuildsAndIsEmpty) {
  Heightfield field(300, 200);
  for (int r = 0; r < 200; ++r)
    for (int c = 0; c < 300; ++c) field[{c, r}] = kNoData;
  TemporaryFolder folder;
  const auto terrain = Terrain::open(build_store(folder, field));
  EXPECT_EQ(terrain->manifest().nodata_share, 1);
  EXPECT_EQ(terrain->manifest().drawable_cells, 0U);
  EXPECT_TRUE(terrain->keys("heights").empty());
  EXPECT_EQ(first_difference(field, *terrain->height_source(), 0), "");
}

TEST(RoundTripTest, InfinitiesAreHoles) {
  Heightfield field = make_hills(140, 140, 3);
  field[{5, 5}] = std::numeric_limits<float>::infinity();
  field[{130, 90}] = -std::numeric_limits<float>::infinity();
  TemporaryFolder folder;
  const auto terrain = Terrain::open(build_store(folder, field));
  field[{5, 5}] = field[{130, 90}] = kNoData;
  EXPECT_EQ(first_difference(field, *terrain->height_source(), 0), "");
  EXPECT_NEAR(terrain->manifest().nodata_share, 2.0 / (140 * 140), 1e-12);
}

// Floats of a range that 2^-10 m cannot hold: the lattice is made coarser, and the error told is
// the largest there is.
TEST(RoundTripTest, FloatsKeepTheErrorThatTheManifestStates) {
  for (const float range : {10.0F, 3e4F, 3e8F, 1e30F}) {
    SCOPED_TRACE(range);
    Heightfield field(200, 131);
    std::mt19937 random(5);
    std::uniform_real_distribution<float> height(-range, range);
    for (int r = 0; r < 131; ++r)
      for (int c = 0; c < 200; ++c) field[{c, r}] = height(random);
    TemporaryFolder folder;
    const auto terrain = Terrain::open(build_store(folder, field));
    const Manifest& m = terrain->manifest();
    EXPECT_LE(m.max_store_error_m, m.quantum_m / 2);
    EXPECT_EQ(std::exp2(std::round(std::log2(m.quantum_m))), m.quantum_m);
    EXPECT_EQ(first_difference(field, *terrain->height_source(), m.max_store_error_m), "");
    // Negative control: a smaller bound must be broken.
    if (m.max_store_error_m > 0) {
      EXPECT_NE(first_difference(field, *terrain->height_source(), m.max_store_error_m * 0.99), "");
    }
  }
}

TEST(RoundTripTest, FeetAndOffsetsAreLossless) {
  Heightfield field(150, 150);
  std::mt19937 random(9);
  for (int r = 0; r < 150; ++r)
    for (int c = 0; c < 150; ++c)
      field[{c, r}] = static_cast<float>(100.5 + 0.3048 * static_cast<int>(random() % 20000));
  field.set_lattice({true, 0.3048, 100.5});
  TemporaryFolder folder;
  const auto terrain = Terrain::open(build_store(folder, field));
  EXPECT_EQ(terrain->manifest().max_store_error_m, 0);
  EXPECT_EQ(first_difference(field, *terrain->height_source(), 0), "");
}

// Filled heights lie within the data's range and do not depend on what stands in the hole.
TEST(RoundTripTest, HolesAreFilledWithinTheRange) {
  Heightfield field = make_hills(500, 400, 21);
  punch_holes(field, 6, 2);
  TemporaryFolder folder;
  const auto terrain = Terrain::open(build_store(folder, field));
  const Manifest& m = terrain->manifest();
  int filled = 0;
  for (const std::uint64_t key : terrain->keys("heights")) {
    const auto tile = terrain->heights(TileId::from_key(key), Fetch::Wait);
    ASSERT_TRUE(tile);
    for (const std::int32_t count : tile->counts) {
      ASSERT_GE(terrain->z_of(count), m.z_min);
      ASSERT_LE(terrain->z_of(count), m.z_max);
    }
    filled += tile->valid.empty() ? 0 : 1;
  }
  EXPECT_GT(filled, 0);
}

}  // namespace
}  // namespace arete::store
