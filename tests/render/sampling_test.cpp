#include <cmath>

#include "render/gl_test.h"
#include "render/toy_land.h"

namespace arete::render {
namespace {

constexpr int kPosts = 3001;
constexpr int kStripe = 512;  // posts

class Sampling : public GlTest {};

/// Data in stripes of a checker board; `shift` moves the board, in posts.
class Checkers {
 public:
  Checkers(int texels_per_post_log2, double shift)
      : log2_(texels_per_post_log2), shift_(shift), raster_(side(), side(), 1, 64, texel()) {
    raster_.set_texels_per_post_log2(texels_per_post_log2);
  }
  const RasterSource& raster() const { return raster_; }
  static bool valid(glm::dvec2 post) { return (stripe(post.x) + stripe(post.y)) % 2 == 0; }

 private:
  static int stripe(double v) { return static_cast<int>(std::floor(v / kStripe)); }
  int side() const { return (kPosts - 1) * (1 << log2_) + 1; }
  ToyRaster::Texel texel() const {
    const double texels = 1 << log2_;
    const double shift = shift_;
    return [texels, shift](int level, int x, int y, int) {
      const glm::dvec2 middle = (glm::dvec2(x, y) + 0.5) * std::ldexp(1.0, level) - 0.5;
      return static_cast<std::uint8_t>(valid(middle / texels + shift) ? 255 : 0);
    };
  }
  int log2_;
  double shift_;
  ToyRaster raster_;
};

/// Two triangles over the whole grid, at height 0.
DrawList quad() {
  DrawList list;
  for (const Post p :
       {Post{0, 0}, Post{kPosts - 1, 0}, Post{0, kPosts - 1}, Post{kPosts - 1, kPosts - 1}}) {
    Vertex v;
    v.post = p;
    list.vertices.push_back(v);
  }
  list.indices = {0, 2, 1, 1, 2, 3};
  DrawBatch batch;
  batch.index_count = 6;
  list.batches.push_back(batch);
  return list;
}

View view_over(glm::dvec2 post, double height, double pitch) {
  Pose pose;
  pose.eye = {post.x, -post.y, height};
  pose.yaw = 0.4;
  pose.pitch = pitch;
  return make_view(pose, 120, 90);
}

struct Count {
  int checked = 0, wrong = 0;
};

// Pixels that should show data and do not, or the other way about; those within a few texels of a
// stripe's edge are left out.
Count compare(const Picture& picture, const View& view) {
  Count count;
  for (int row = 0; row < view.viewport_height; ++row) {
    for (int x = 0; x < view.viewport_width; ++x) {
      const glm::dvec3 hit = hit_plane(view, x + 0.5, view.viewport_height - row - 0.5);
      const glm::dvec2 post(hit.x, -hit.y);
      if (!(hit.z > 0) || post.x < 1 || post.y < 1 || post.x > kPosts - 2 || post.y > kPosts - 2) {
        continue;
      }
      // The window of 128 texels reaches 62 from its centre; a pixel spans more when far away.
      const double reach = glm::length(post - glm::dvec2(view.eye.x, -view.eye.y)) / 31;
      const double near_edge = 2 + 4 * std::max(reach, hit.z * hit.z / view.eye.z / 80);
      const auto to_edge = [](double v) {
        return std::abs(v / kStripe - std::round(v / kStripe)) * kStripe;
      };
      if (std::min(to_edge(post.x), to_edge(post.y)) < near_edge) continue;
      ++count.checked;
      const auto i = static_cast<std::size_t>((row * view.viewport_width + x) * 3);
      const bool drawn = picture[i + 1] == kKeyLand[1];
      count.wrong += drawn == Checkers::valid(post) ? 0 : 1;
    }
  }
  return count;
}

Count shoot_and_compare(const Checkers& checkers, const std::vector<View>& flight) {
  const ToyLand none(1, 1, 0);
  Land land;
  land.cols = land.rows = kPosts;
  land.validity = &checkers.raster();
  Renderer renderer(land, std::size_t{2} << 20U);  // so little that the windows must move
  Style style;
  style.shading = Shading::Key;
  Count sum;
  for (const View& view : flight) {
    const Count c = compare(shoot(renderer, view, quad(), none, style), view);
    sum.checked += c.checked;
    sum.wrong += c.wrong;
  }
  return sum;
}

std::vector<View> flight() {
  return {view_over({100, 100}, 60, -0.5),    view_over({1500, 1500}, 40, -0.9),
          view_over({1700, 1333}, 200, -1.3), view_over({2900, 2950}, 30, -0.3),
          view_over({-200, 3500}, 400, -0.4), view_over({1024, 2048}, 900, -1.5)};
}

TEST_F(Sampling, TheGroundShowsTheRasterAtItsPlaceWhereverTheCameraIs) {
  for (const int texels_per_post_log2 : {0, 1}) {
    SCOPED_TRACE(texels_per_post_log2);
    const Checkers checkers(texels_per_post_log2, 0);
    const Count count = shoot_and_compare(checkers, flight());
    EXPECT_GT(count.checked, 15000);
    EXPECT_EQ(count.wrong, 0);
  }
}

TEST_F(Sampling, AShiftedRasterIsFound) {
  const Checkers shifted(0, 64);
  EXPECT_GT(shoot_and_compare(shifted, flight()).wrong, 100);
}

TEST_F(Sampling, FewTilesAFrameEndInTheSamePicture) {
  const Checkers checkers(0, 0);
  const ToyLand none(1, 1, 0);
  Land land;
  land.cols = land.rows = kPosts;
  land.validity = &checkers.raster();
  Style style;
  style.shading = Shading::Key;
  const View view = view_over({1500, 1500}, 40, -0.9);
  Renderer at_once(land, std::size_t{2} << 20U);
  const Picture complete = shoot(at_once, view, quad(), none, style);
  Renderer bit_by_bit(land, std::size_t{2} << 20U);
  style.texture_tiles = 3;
  EXPECT_GT(different_pixels(complete, shoot(bit_by_bit, view, quad(), none, style)), 0);
  Picture last;
  for (int frame = 0; frame < 20; ++frame) last = shoot(bit_by_bit, view, quad(), none, style);
  EXPECT_EQ(different_pixels(complete, last), 0);
}

TEST_F(Sampling, ADrapeReplacesTheTint) {
  const ToyLand none(1, 1, 0);
  const ToyRaster red(kPosts, kPosts, 3, 64, [](int, int, int, int channel) {
    return static_cast<std::uint8_t>(channel == 0 ? 200 : 10);
  });
  Land land;
  land.cols = land.rows = kPosts;
  land.z_max = 100;
  land.drape = &red;
  Renderer renderer(land);
  const View view = view_over({1500, 1500}, 40, -0.9);
  const Picture picture = shoot(renderer, view, quad(), none, Style{});
  const std::size_t middle = (45 * 120 + 60) * 3;
  EXPECT_GT(picture[middle], 2 * picture[middle + 1]);
  EXPECT_GT(picture[middle], 2 * picture[middle + 2]);
}

}  // namespace
}  // namespace arete::render
