#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "arete/proof/leaks.h"
#include "arete/proof/rasteriser.h"

#include "mesh/toy_surface.h"

namespace arete::proof {
namespace {

View view_over(const Heightfield& dem, double height, double pitch) {
  return make_view(
      {.eye = {dem.cols() / 2.0, -dem.rows() / 2.0, height}, .yaw = 0.4, .pitch = pitch}, 160, 120);
}

std::size_t drawn_pixels(const Picture& p) {
  return static_cast<std::size_t>(std::ranges::count_if(p.depth, [](float d) { return d > 0; }));
}

// Distance along the view axis at which a pixel's ray meets the triangle; infinite when it misses.
double ray_depth(const View& view, const mesh::Surface& s, std::size_t triangle, glm::dvec2 ndc) {
  const glm::dmat4 inverse = glm::inverse(clip_from_camera(view));
  const glm::dvec4 far = inverse * glm::dvec4(ndc, 0, 1);  // a direction
  glm::dvec3 p[3];
  for (std::size_t k = 0; k < 3; ++k) {
    const mesh::SurfaceVertex& v = s.vertices[s.indices[3 * triangle + k]];
    p[k] = glm::dvec3(v.post.col, -v.post.row, double{v.z}) - view.eye;
  }
  const glm::dvec3 d(far);
  const glm::dvec3 n = glm::cross(p[1] - p[0], p[2] - p[0]);
  const double t = glm::dot(n, p[0]) / glm::dot(n, d);
  const glm::dvec3 hit = t * d;
  for (std::size_t k = 0; k < 3; ++k) {
    if (glm::dot(n, glm::cross(p[(k + 1) % 3] - p[k], hit - p[k])) < 0) {
      return std::numeric_limits<double>::infinity();
    }
  }
  const double along = glm::dot(hit, view.forward());
  return along >= view.near_m ? along : std::numeric_limits<double>::infinity();
}

TEST(Rasterise, AgreesWithRays) {
  const Heightfield dem = toy::hills(17, 17);
  const mesh::Surface s = toy::surface_of(toy::all_cells(17, 17), dem);
  for (const double pitch : {-1.5, -0.5, 0.1}) {
    SCOPED_TRACE(pitch);
    const View view = view_over(dem, 6, pitch);
    const Picture picture = rasterise(s, dem.georef().world_from_post, view, {.threads = 2});
    int differing = 0;
    for (int y = 0; y < 120; y += 3) {
      for (int x = 0; x < 160; x += 3) {
        const glm::dvec2 ndc{(x + 0.5) / 80 - 1, 1 - (y + 0.5) / 60};
        double nearest = std::numeric_limits<double>::infinity();
        for (std::size_t t = 0; t < s.triangles(); ++t) {
          nearest = std::min(nearest, ray_depth(view, s, t, ndc));
        }
        const double expected = std::isinf(nearest) ? 0 : view.near_m / nearest;
        const float got = picture.depth[static_cast<std::size_t>(160 * y + x)];
        differing += static_cast<int>(std::abs(double{got} - expected) > 0.02 * expected);
      }
    }
    EXPECT_LE(differing, 8);  // of 2160: pixels at silhouettes, by the snapping
  }
}

TEST(Rasterise, LeavesNoPixelInsideTheSilhouette) {
  for (std::uint32_t seed = 0; seed < 6; ++seed) {
    SCOPED_TRACE(seed);
    const Heightfield dem = toy::hills(65, 65, seed);
    const mesh::Surface s = toy::surface_of(toy::RandomRtin(64, seed).triangles(), dem);
    const View view = view_over(dem, 9, -1.5);
    const Picture picture = rasterise(s, dem.georef().world_from_post, view, {});
    EXPECT_EQ(drawn_pixels(picture), picture.depth.size());
  }
}

TEST(Rasterise, DrawsEachPixelOfAFlatSurfaceOnce) {
  // Additive coverage: shared edges belong to one triangle only.
  Heightfield dem(17, 17);
  const std::vector<toy::Triangle> triangles = toy::RandomRtin(16, 1).triangles();
  const View view = view_over(dem, 30, -1.5);
  std::size_t sum = 0;
  for (const toy::Triangle& t : triangles) {
    sum +=
        drawn_pixels(rasterise(toy::surface_of({t}, dem), dem.georef().world_from_post, view, {}));
  }
  EXPECT_EQ(sum, drawn_pixels(rasterise(toy::surface_of(triangles, dem),
                                        dem.georef().world_from_post, view, {})));
}

TEST(Rasterise, DoesNotDependOnThreads) {
  const Heightfield dem = toy::hills(129, 129);
  const mesh::Surface s = toy::surface_of(toy::RandomRtin(128, 1).triangles(), dem);
  const View view = view_over(dem, 8, -0.3);
  const Picture one = rasterise(s, dem.georef().world_from_post, view, {.threads = 1});
  const Picture many = rasterise(s, dem.georef().world_from_post, view, {.threads = 5});
  EXPECT_EQ(one.depth, many.depth);
  EXPECT_EQ(one.triangle, many.triangle);
}

TEST(BackgroundPixels, IgnoreSkyAndSilhouettes) {
  const Heightfield dem = toy::hills(65, 65);
  const mesh::Surface s = toy::surface_of(toy::all_cells(65, 65), dem);
  const View view = view_over(dem, 9, -0.1);
  const Affine2 world = dem.georef().world_from_post;
  const Picture picture = rasterise(s, world, view, {.sample_shift = {0.3, -0.3}});
  EXPECT_LT(drawn_pixels(picture), picture.depth.size());
  EXPECT_EQ(background_pixels(picture.depth, s, world, view, 2), 0U);
}

TEST(BackgroundPixels, FindATriangleThatWasNotDrawn) {
  const Heightfield dem = toy::hills(65, 65);
  const mesh::Surface s = toy::surface_of(toy::all_cells(65, 65), dem);
  const View view = view_over(dem, 25, -1.4);
  const Affine2 world = dem.georef().world_from_post;
  const Picture whole = rasterise(s, world, view, {});
  const std::uint32_t seen = whole.triangle[160 * 60 + 80];
  ASSERT_NE(seen, Picture::kNothing);
  mesh::Surface holed = s;
  holed.indices.erase(holed.indices.begin() + 3 * std::ptrdiff_t{seen},
                      holed.indices.begin() + 3 * std::ptrdiff_t{seen} + 3);
  const std::uint64_t leaks =
      background_pixels(rasterise(holed, world, view, {}).depth, s, world, view, 2);
  EXPECT_GE(leaks, 1U);
  EXPECT_LE(leaks, static_cast<std::uint64_t>(std::ranges::count(whole.triangle, seen)));
}

}  // namespace
}  // namespace arete::proof
