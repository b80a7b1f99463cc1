#include <cmath>
#include <set>

#include "arete/core/error.h"
#include "arete/core/normal_code.h"

#include "render/gl_test.h"
#include "render/toy_land.h"

namespace arete::render {
namespace {

constexpr double kSpacing = 10;

class RendererTest : public GlTest {};

Land land_of(const ToyLand& toy, double origin = 0) {
  Land land;
  land.world_from_post.m = {kSpacing, 0, origin, 0, -kSpacing, -origin};
  land.cols = land.rows = toy.posts();
  land.z_min = -100;
  land.z_max = 400;
  return land;
}

// Over the southern part of the land, looking north and down; the horizon is in the picture.
View slanted_view(const ToyLand& toy, double origin = 0, int width = 160, int height = 120) {
  const double side = (toy.posts() - 1) * kSpacing;
  Pose pose;
  pose.eye = {origin + side * 0.5, -origin - side * 1.125, side * 0.25};
  pose.yaw = 0.125;
  pose.pitch = -0.375;
  return make_view(pose, width, height);
}

Style key_style() {
  Style style;
  style.shading = Shading::Key;
  return style;
}

std::array<std::uint8_t, 3> pixel(const Picture& p, const View& view, int x, int row) {
  const auto i = static_cast<std::size_t>((row * view.viewport_width + x) * 3);
  return {p[i], p[i + 1], p[i + 2]};
}

// Calls f(x, row, post, distance) for every pixel whose ray meets the plane in front of the eye;
// post is fractional. Pixels above the horizon get a NaN post.
template <typename F>
void for_each_pixel(const Land& land, const View& view, F f) {
  for (int row = 0; row < view.viewport_height; ++row) {
    for (int x = 0; x < view.viewport_width; ++x) {
      const glm::dvec3 hit = hit_plane(view, x + 0.5, view.viewport_height - row - 0.5);
      const glm::dvec2 post =
          hit.z > 0 ? land.world_from_post.inverse({hit.x, hit.y}) : glm::dvec2(std::nan(""));
      f(x, row, post, hit.z);
    }
  }
}

bool near_line(double v) {
  return std::abs(v - std::round(v)) < 0.05;
}

TEST_F(RendererTest, AFlatGridFillsWhatTheProjectionSays) {
  const ToyLand toy(2, 1, 0);
  const Land land = land_of(toy);
  const View view = slanted_view(toy);
  Renderer renderer(land);
  const Picture picture = shoot(renderer, view, toy.whole(1), toy, key_style());
  const double last = toy.posts() - 1;
  int inside = 0, outside = 0, wrong = 0;
  for_each_pixel(land, view, [&](int x, int row, glm::dvec2 post, double) {
    const double depth = std::isnan(post.x) ? -1
                                            : std::min(std::min(post.x, last - post.x),
                                                       std::min(post.y, last - post.y));
    if (std::abs(depth) < 0.01) return;
    ++(depth > 0 ? inside : outside);
    const auto expected = depth > 0 ? kKeyLand : kKeyBackground;
    wrong += pixel(picture, view, x, row) == expected ? 0 : 1;
  });
  EXPECT_GT(inside, 1000);
  EXPECT_GT(outside, 1000);
  EXPECT_EQ(wrong, 0);
  EXPECT_EQ(renderer.stats().triangles, 4U * 16 * 16 * 2);
  EXPECT_EQ(renderer.stats().dropped_batches, 0U);
}

TEST_F(RendererTest, DepthIsTheDistanceAlongTheViewAxis) {
  const ToyLand toy(2, 1, 0);
  const Land land = land_of(toy);
  const View view = slanted_view(toy);
  Renderer renderer(land);
  Frame frame(view.viewport_width, view.viewport_height);
  renderer.draw(view, toy.whole(1), toy, Style{}, frame);
  const std::vector<float> depth = frame.read_depth();
  int seen = 0;
  for_each_pixel(land, view, [&](int x, int row, glm::dvec2, double distance) {
    const double d = depth[static_cast<std::size_t>(row * view.viewport_width + x)];
    if (d == 0) return;
    ++seen;
    EXPECT_NEAR(view.near_m / d, distance, 1e-4 * distance);
  });
  EXPECT_GT(seen, 1000);
}

TEST_F(RendererTest, TheMaskDropsCellsWithoutData) {
  const ToyLand toy(2, 1, 0);
  const auto valid = [](int x, int y) { return !(x >= 10 && x < 14 && y >= 20 && y < 23); };
  const ToyRaster validity(toy.posts(), toy.posts(), 1, 64, [&](int, int x, int y, int) {
    return static_cast<std::uint8_t>(valid(x, y) ? 255 : 0);
  });
  Land land = land_of(toy);
  land.validity = &validity;
  Pose pose;
  pose.eye = {120, -220, 100};  // near enough for a post to span pixels
  pose.pitch = -1.4;
  const View view = make_view(pose, 200, 160);
  Renderer renderer(land);
  Style style = key_style();
  const Picture picture = shoot(renderer, view, toy.whole(1), toy, style);
  int holes = 0, wrong = 0;
  for_each_pixel(land, view, [&](int x, int row, glm::dvec2 post, double) {
    const double last = toy.posts() - 1;
    if (near_line(post.x) || near_line(post.y)) return;
    if (!(post.x > 0 && post.y > 0 && post.x < last && post.y < last)) return;
    const int c = static_cast<int>(post.x);
    const int r = static_cast<int>(post.y);
    const bool drawable = valid(c, r) && valid(c + 1, r) && valid(c, r + 1) && valid(c + 1, r + 1);
    holes += drawable ? 0 : 1;
    wrong += pixel(picture, view, x, row) == (drawable ? kKeyLand : kKeyBackground) ? 0 : 1;
  });
  EXPECT_GT(holes, 200);
  EXPECT_EQ(wrong, 0);
  style.mask = false;
  EXPECT_GT(different_pixels(picture, shoot(renderer, view, toy.whole(1), toy, style)), 200);
}

TEST_F(RendererTest, WireframeDrawsEdgesOverTheLand) {
  const ToyLand toy(2, 3, 5);
  Renderer renderer(land_of(toy));
  const View view = slanted_view(toy);
  Style style;
  const Picture plain = shoot(renderer, view, toy.whole(1), toy, style);
  style.wireframe = true;
  const int changed = different_pixels(plain, shoot(renderer, view, toy.whole(1), toy, style), 8);
  EXPECT_GT(changed, 500);
  EXPECT_LT(changed, view.viewport_width * view.viewport_height * 3 / 4);
}

TEST_F(RendererTest, WithoutMorphEveryFactorIsZero) {
  const ToyLand toy(2, 3, 40);
  Renderer renderer(land_of(toy));
  const View view = slanted_view(toy);
  DrawList list = toy.whole(1);
  Style style;
  const Picture morphed = shoot(renderer, view, list, toy, style);
  style.morph = false;
  const Picture still = shoot(renderer, view, list, toy, style);
  EXPECT_GT(different_pixels(morphed, still, 8), 100);
  for (DrawBatch& batch : list.batches) batch.factor.fill(0);
  style.morph = true;
  EXPECT_EQ(different_pixels(still, shoot(renderer, view, list, toy, style)), 0);
}

ToyRaster some_normals(int posts) {
  return {posts, posts, 2, 64, [](int level, int x, int y, int channel) {
            const double slope = 0.4 * std::sin(0.3 * x * (1 << level) + 0.2 * y + channel);
            return encode_normal(glm::normalize(glm::dvec3(slope, slope, 1)))[0];
          }};
}

TEST_F(RendererTest, AFarWorldOriginGivesTheSamePicture) {
  const ToyLand toy(8, 4, 30);
  const ToyRaster normals = some_normals(toy.posts());
  Picture pictures[2];
  for (const int far : {0, 1}) {
    const double origin = far * 6.4e6;
    Land land = land_of(toy, origin);
    land.normals = &normals;
    Renderer renderer(land);
    pictures[far] = shoot(renderer, slanted_view(toy, origin), toy.whole(2), toy, Style{});
  }
  EXPECT_EQ(different_pixels(pictures[0], pictures[1], 1), 0);
}

TEST_F(RendererTest, AFrameDependsOnItsViewAlone) {
  const ToyLand toy(8, 4, 30);
  const ToyRaster normals = some_normals(toy.posts());
  Land land = land_of(toy);
  land.normals = &normals;
  Renderer renderer(land);
  const View view = slanted_view(toy);
  const Picture first = shoot(renderer, view, toy.whole(2), toy, Style{});
  EXPECT_GT(std::set<std::uint8_t>(first.begin(), first.end()).size(), 20U);
  Pose elsewhere;
  elsewhere.eye = {1200, -100, 50};
  shoot(renderer, make_view(elsewhere, 160, 120), toy.whole(3), toy, Style{});
  EXPECT_EQ(different_pixels(first, shoot(renderer, view, toy.whole(2), toy, Style{})), 0);
  Renderer fresh(land);
  EXPECT_EQ(different_pixels(first, shoot(fresh, view, toy.whole(2), toy, Style{})), 0);
}

TEST_F(RendererTest, StripsDrawWhatListsDraw) {
  const ToyLand toy(1, 5, 20);
  Renderer renderer(land_of(toy));
  const View view = slanted_view(toy);
  DrawList list = toy.whole(6);
  const Picture expected = shoot(renderer, view, list, toy, key_style());
  const std::uint32_t side = ToyLand::kTileCells + 1;
  for (std::uint32_t r = 0; r + 1 < side; ++r) {
    if (r > 0) list.indices.insert(list.indices.end(), {list.indices.back(), r * side});
    for (std::uint32_t c = 0; c < side; ++c) {
      list.indices.insert(list.indices.end(), {r * side + c, (r + 1) * side + c});
    }
  }
  DrawBatch& batch = list.batches[0];
  batch.topology = Topology::Strip;
  batch.indices = kOwnBlock;
  batch.index_count = static_cast<std::uint32_t>(list.indices.size());
  EXPECT_EQ(different_pixels(expected, shoot(renderer, view, list, toy, key_style())), 0);
}

TEST_F(RendererTest, AnEmptyListShowsTheSky) {
  const ToyLand toy(1, 5, 20);
  Renderer renderer(land_of(toy));
  const View view = slanted_view(toy);
  const Picture sky = shoot(renderer, view, DrawList{}, toy, Style{});
  EXPECT_GT(sky[2], sky[0]);  // blue above red, at the top
  const Picture key = shoot(renderer, view, DrawList{}, toy, key_style());
  EXPECT_EQ(pixel(key, view, 80, 60), kKeyBackground);
}

}  // namespace
}  // namespace arete::render
