#include "arete/proof/residual.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "arete/proof/pop.h"

#include "mesh/toy_surface.h"

namespace arete::proof {
namespace {

View view_over(const Heightfield& dem, double height, double pitch) {
  return make_view(
      {.eye = {dem.cols() / 2.0, -dem.rows() / 2.0, height}, .yaw = 0.7, .pitch = pitch}, 320, 240);
}

double image_distance(const View& v, glm::dvec3 a, glm::dvec3 b) {
  const glm::dvec3 d = project(v, a) - project(v, b);
  return std::hypot(d.x, d.y);
}

// Height of the surface at a post by looking at every triangle; worst against the truth.
double slow_height(const mesh::Surface& s, Post p, double truth) {
  double worst = std::nan("");
  for (std::size_t i = 0; i < s.indices.size(); i += 3) {
    glm::dvec3 q[3];
    for (std::size_t k = 0; k < 3; ++k) {
      const mesh::SurfaceVertex& v = s.vertices[s.indices[i + k]];
      q[k] = {v.post.col + double{v.dcol}, v.post.row + double{v.drow}, double{v.z}};
    }
    const auto cross = [&](const glm::dvec3& a, const glm::dvec3& b) {
      return (b.x - a.x) * (p.row - a.y) - (b.y - a.y) * (p.col - a.x);
    };
    const double u = cross(q[1], q[2]);
    const double v = cross(q[2], q[0]);
    const double w = cross(q[0], q[1]);
    if (u + v + w == 0 || std::max({u, v, w}) > 1e-9) continue;
    const double z = (u * q[0].z + v * q[1].z + w * q[2].z) / (u + v + w);
    if (!(std::abs(z - truth) <= std::abs(worst - truth))) worst = z;
  }
  return worst;
}

TEST(Residuals, EqualASlowEvaluationOfEveryPost) {
  for (std::uint32_t seed = 0; seed < 4; ++seed) {
    SCOPED_TRACE(seed);
    const Heightfield dem = toy::hills(65, 65, seed);
    const mesh::Surface s = toy::surface_of(toy::RandomRtin(64, seed).triangles(), dem);
    const View view = view_over(dem, 15, -0.6);
    double max_px = 0;
    double max_angle = 0;
    std::uint64_t posts = 0;
    for (int r = 0; r < 65; ++r) {
      for (int c = 0; c < 65; ++c) {
        const double truth = double{dem[{c, r}]};
        const glm::dvec3 at{double(c), double(-r), truth};
        const glm::dvec3 image = project(view, at);
        if (image.z < view.near_m || image.x < 0 || image.x > 320 || image.y < 0 || image.y > 240) {
          continue;
        }
        ++posts;
        const double z = slow_height(s, {c, r}, truth);
        max_px = std::max(max_px, image_distance(view, at, {at.x, at.y, z}));
        max_angle = std::max(max_angle, pixel_scale(view, ErrorScale::Angular) *
                                            std::abs(z - truth) / glm::length(at - view.eye));
      }
    }
    const Reference reference(dem, 1);
    const Residuals got = measure_residuals(s, reference, view, 1);
    EXPECT_EQ(got.px.count(), posts);
    EXPECT_NEAR(got.px.max_px(), max_px, 1e-9 * max_px);
    EXPECT_NEAR(got.max_angular_px, max_angle, 1e-9 * max_angle);
    EXPECT_EQ(got.undrawn, 0U);
    EXPECT_GT(posts, 100U);
  }
}

TEST(Residuals, DoNotDependOnThreads) {
  const Heightfield dem = toy::hills(257, 257);
  const mesh::Surface s = toy::surface_of(toy::RandomRtin(256, 4).triangles(), dem);
  const Reference reference(dem, 2);
  const View view = view_over(dem, 60, -0.9);
  const Residuals one = measure_residuals(s, reference, view, 1);
  const Residuals four = measure_residuals(s, reference, view, 4);
  EXPECT_EQ(one.px.max_px(), four.px.max_px());
  EXPECT_EQ(one.px.quantile_px(0.999), four.px.quantile_px(0.999));
  EXPECT_EQ(one.max_angular_px, four.max_angular_px);
}

TEST(Residuals, ScaleWithTheSurfacesError) {
  const Heightfield dem = toy::hills(65, 65);
  const Reference reference(dem, 1);
  const View view = view_over(dem, 500, -1.4);
  mesh::Surface s = toy::surface_of(toy::all_cells(65, 65), dem);
  EXPECT_EQ(measure_residuals(s, reference, view, 1).px.max_px(), 0);
  for (mesh::SurfaceVertex& v : s.vertices) v.z += 1;
  const double one = measure_residuals(s, reference, view, 1).px.max_px();
  for (mesh::SurfaceVertex& v : s.vertices) v.z += 0.1F;
  const double more = measure_residuals(s, reference, view, 1).px.max_px();
  EXPECT_GT(one, 0.01);
  EXPECT_NEAR(more / one, 1.1, 0.01);
}

TEST(Residuals, SeeEveryPostOfAMovedSurface) {
  const Heightfield dem = toy::hills(65, 65);
  const Reference reference(dem, 1);
  mesh::Surface s = toy::surface_of(toy::RandomRtin(64, 9).triangles(), dem);
  std::mt19937 random(7);
  std::uniform_real_distribution<float> shift(-0.3F, 0.3F);
  for (mesh::SurfaceVertex& v : s.vertices) {
    if (v.post.col % 64 == 0 || v.post.row % 64 == 0) continue;
    v.dcol = shift(random);
    v.drow = shift(random);
  }
  int posts = 0;
  for_each_residual(s, reference, [&](const PostResidual& p) {
    ++posts;
    EXPECT_NEAR(p.drawn_z, slow_height(s, p.post, p.true_z), 1e-4);
  });
  EXPECT_EQ(posts, 65 * 65);
}

TEST(Residuals, LeaveOutPostsThatTouchNoDrawableCell) {
  Heightfield dem = toy::hills(33, 33);
  for (int i = 0; i < 33; ++i) dem[{16, i}] = dem[{i, 16}] = std::nanf("");
  dem[{16, 16}] = 3;  // has data and no drawable cell
  const Reference reference(dem, 1);
  int posts = 0;
  for_each_residual(toy::surface_of(toy::all_cells(33, 33), dem), reference,
                    [&](const PostResidual&) { ++posts; });
  EXPECT_EQ(posts, 4 * 16 * 16);
}

TEST(Residuals, AreInfiniteForASurfaceDrawnBehindTheEye) {
  const Heightfield dem = toy::hills(33, 33);
  mesh::Surface s = toy::surface_of(toy::all_cells(33, 33), dem);
  const View view = view_over(dem, 20, -1.5);
  for (mesh::SurfaceVertex& v : s.vertices) v.z += 40;
  EXPECT_TRUE(std::isinf(measure_residuals(s, Reference(dem, 1), view, 1).px.max_px()));
}

TEST(Residuals, CountPostsThatNoTriangleCovers) {
  const Heightfield dem = toy::hills(33, 33);
  std::vector<toy::Triangle> half = toy::all_cells(33, 33);
  half.resize(half.size() / 2);
  const Residuals r =
      measure_residuals(toy::surface_of(half, dem), Reference(dem, 1), view_over(dem, 60, -1.5), 1);
  EXPECT_GT(r.undrawn, 100U);
}

TEST(PixelHistogram, QuantilesAreTightFromAbove) {
  PixelHistogram h;
  EXPECT_EQ(h.quantile_px(0.999), 0);
  for (int i = 1; i <= 10000; ++i) {
    const double px = i / 1000.0;
    h.add_squared(px * px);
  }
  EXPECT_EQ(h.max_px(), 10);
  EXPECT_EQ(h.quantile_px(1), 10);
  EXPECT_GE(h.quantile_px(0.5), 5 - 1e-12);
  EXPECT_LE(h.quantile_px(0.5), 5 * 1.004);
  h.add_squared(std::nan(""));
  EXPECT_TRUE(std::isinf(h.max_px()));
}

TEST(Pops, AreZeroForTheSameSurface) {
  const Heightfield dem = toy::hills(65, 65);
  const mesh::Surface s = toy::surface_of(toy::RandomRtin(64, 2).triangles(), dem);
  const View a = view_over(dem, 20, -0.8);
  const View b = view_over(dem, 21, -0.8);
  const PixelHistogram pops = measure_pops({a, b, s, s}, Reference(dem, 1), 1);
  EXPECT_GT(pops.count(), 100U);
  EXPECT_EQ(pops.max_px(), 0);
}

TEST(Pops, FindOnePostThatJumps) {
  const Heightfield dem = toy::hills(65, 65);
  const mesh::Surface before = toy::surface_of(toy::all_cells(65, 65), dem);
  mesh::Surface after = before;
  const View a = view_over(dem, 30, -1.4);
  const View b = view_over(dem, 30.5, -1.4);
  mesh::SurfaceVertex* moved = nullptr;
  for (mesh::SurfaceVertex& v : after.vertices) {
    if (v.post == Post{30, 33}) moved = &v;
  }
  ASSERT_NE(moved, nullptr);
  const glm::dvec3 was{30, -33, double{moved->z}};
  moved->z += 0.5F;
  const PixelHistogram pops = measure_pops({a, b, before, after}, Reference(dem, 1), 2);
  EXPECT_NEAR(pops.max_px(), image_distance(b, was, {30, -33, double{moved->z}}), 1e-9);
  EXPECT_EQ(pops.quantile_px(0.99), 0);
}

TEST(Pops, PromiseFollowsTheRelativeMotion) {
  const View a = make_view({.eye = {0, 0, 10}}, 100, 100);
  const View b = make_view({.eye = {0, 3, 14}}, 100, 100);
  EXPECT_DOUBLE_EQ(relative_motion(a, b, ErrorScale::Upright, 50), 0.1);
  EXPECT_EQ(relative_motion(a, a, ErrorScale::Upright, 0), 0);
  EXPECT_EQ(pop_share(0, 6, 0), 0);
  EXPECT_EQ(pop_share(3, std::numeric_limits<double>::infinity(), 0), 0);
  EXPECT_TRUE(std::isinf(pop_share(1e-9, 6, 0)));
}

}  // namespace
}  // namespace arete::proof
