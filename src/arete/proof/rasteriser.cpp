#include "arete/proof/rasteriser.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>
#include <utility>

#include "arete/core/parallel.h"
#include "arete/mesh/post_projection.h"

namespace arete::proof {
namespace {

constexpr int kSubpixels = 256;
constexpr int kBandRows = 32;
// Corners further out than this many half viewports are clipped off, so that differences of snapped
// coordinates fit 32 bits up to 65,000 px a side and their products 64.
constexpr double kGuard = 128;

struct ScreenTriangle {
  std::array<std::int32_t, 3> x, y;  // 1/256 px, right and down; clockwise on the screen
  std::array<float, 3> depth;
  std::uint32_t number;
};

using Polygon = std::vector<glm::dvec3>;  // clip coordinates x, y, w

// Where edge ab meets the plane; the same bits whichever way the edge is walked, so that
// neighbouring triangles still share the corner.
glm::dvec3 meet(glm::dvec3 a, glm::dvec3 b, glm::dvec4 plane) {
  if (std::tie(b.x, b.y, b.z) < std::tie(a.x, a.y, a.z)) std::swap(a, b);
  const double da = glm::dot(glm::dvec3(plane), a) + plane.w;
  const double db = glm::dot(glm::dvec3(plane), b) + plane.w;
  return a + (b - a) * (da / (da - db));
}

// Sutherland-Hodgman against one plane: keeps plane.(x, y, w, 1) >= 0.
void clip(const Polygon& in, glm::dvec4 plane, Polygon& out) {
  out.clear();
  const auto inside = [&](glm::dvec3 p) { return glm::dot(glm::dvec3(plane), p) + plane.w >= 0; };
  for (std::size_t i = 0; i < in.size(); ++i) {
    const glm::dvec3& a = in[i];
    const glm::dvec3& b = in[(i + 1) % in.size()];
    if (inside(a)) out.push_back(a);
    if (inside(a) != inside(b)) out.push_back(meet(a, b, plane));
  }
}

// Turns triangles of a surface into triangles on the screen.
class Setup {
 public:
  Setup(const mesh::Surface& surface, const Affine2& world_from_post, const View& view,
        glm::dvec2 shift)
      : surface_(surface),
        projection_(view, world_from_post),
        view_(view),
        shift_(shift),
        planes_{{{0, 0, 1, -view.near_m},
                 {1, 0, kGuard, 0},
                 {-1, 0, kGuard, 0},
                 {0, 1, kGuard, 0},
                 {0, -1, kGuard, 0}}} {}

  void add(std::uint32_t number, std::vector<ScreenTriangle>& out) {
    polygon_.clear();
    for (std::size_t k = 0; k < 3; ++k) {
      const mesh::SurfaceVertex& v =
          surface_.vertices[surface_.indices[3 * std::size_t{number} + k]];
      polygon_.push_back(
          projection_.clip(double{v.dcol} + v.post.col, double{v.drow} + v.post.row, double{v.z}));
    }
    if (outside_viewport()) return;
    for (const glm::dvec4& plane : planes_) {
      if (all_inside(plane)) continue;
      clip(polygon_, plane, clipped_);
      std::swap(polygon_, clipped_);
    }
    for (std::size_t i = 2; i < polygon_.size(); ++i) {
      emit({polygon_[0], polygon_[i - 1], polygon_[i]}, number, out);
    }
  }

 private:
  bool all_inside(glm::dvec4 plane) const {
    return std::ranges::all_of(
        polygon_, [&](glm::dvec3 p) { return glm::dot(glm::dvec3(plane), p) + plane.w >= 0; });
  }

  // Wholly beyond one side of the viewport; samples may lie half a pixel outside it.
  bool outside_viewport() const {
    const double wide = 1 + 2.0 / std::min(view_.viewport_width, view_.viewport_height);
    const auto all = [&](auto test) { return std::ranges::all_of(polygon_, test); };
    return all([&](glm::dvec3 c) { return c.z < view_.near_m; }) ||
           all([&](glm::dvec3 c) { return c.x < -wide * c.z; }) ||
           all([&](glm::dvec3 c) { return c.x > wide * c.z; }) ||
           all([&](glm::dvec3 c) { return c.y < -wide * c.z; }) ||
           all([&](glm::dvec3 c) { return c.y > wide * c.z; });
  }

  void emit(const std::array<glm::dvec3, 3>& corners, std::uint32_t number,
            std::vector<ScreenTriangle>& out) const {
    ScreenTriangle t{};
    t.number = number;
    for (std::size_t k = 0; k < 3; ++k) {
      const glm::dvec3& c = corners[k];
      const double x = (0.5 + 0.5 * c.x / c.z) * view_.viewport_width - shift_.x;
      const double y = (0.5 - 0.5 * c.y / c.z) * view_.viewport_height - shift_.y;
      t.x[k] = static_cast<std::int32_t>(std::lround(x * kSubpixels));
      t.y[k] = static_cast<std::int32_t>(std::lround(y * kSubpixels));
      t.depth[k] = static_cast<float>(view_.near_m / c.z);
    }
    const std::int64_t area = std::int64_t{t.x[1] - t.x[0]} * (t.y[2] - t.y[0]) -
                              std::int64_t{t.y[1] - t.y[0]} * (t.x[2] - t.x[0]);
    if (area == 0) return;
    if (area < 0) {
      std::swap(t.x[1], t.x[2]);
      std::swap(t.y[1], t.y[2]);
      std::swap(t.depth[1], t.depth[2]);
    }
    out.push_back(t);
  }

  const mesh::Surface& surface_;
  mesh::PostProjection projection_;
  const View& view_;
  glm::dvec2 shift_;
  std::array<glm::dvec4, 5> planes_;
  Polygon polygon_, clipped_;
};

// One side of a triangle: >= 0 inside, with the top-left rule worked in.
struct Side {
  std::int64_t dx, dy, value;  // change for a step of one pixel right and down; at the first pixel

  Side(const ScreenTriangle& t, std::size_t from, std::int64_t px, std::int64_t py) {
    const std::size_t to = (from + 1) % 3;
    const std::int64_t ex = std::int64_t{t.x[to]} - t.x[from];
    const std::int64_t ey = std::int64_t{t.y[to]} - t.y[from];
    dx = -ey * kSubpixels;
    dy = ex * kSubpixels;
    value = ex * (py - t.y[from]) - ey * (px - t.x[from]);
    // Clockwise with y down: a left side goes up, a top side goes right.
    const bool top_left = ey < 0 || (ey == 0 && ex > 0);
    if (!top_left) --value;
  }
};

int first_pixel(std::int32_t subpixel) {
  return (subpixel - kSubpixels / 2 + kSubpixels - 1) >> 8;  // first centre at or after it
}

// Draws the rows [row0, row1) of one triangle.
void draw(const ScreenTriangle& t, int row0, int row1, Picture& out) {
  const auto [x_lo, x_hi] = std::minmax({t.x[0], t.x[1], t.x[2]});
  const auto [y_lo, y_hi] = std::minmax({t.y[0], t.y[1], t.y[2]});
  const int x0 = std::max(first_pixel(x_lo), 0);
  const int x1 = std::min(first_pixel(x_hi) + 1, out.width);
  const int y0 = std::max(first_pixel(y_lo), row0);
  const int y1 = std::min(first_pixel(y_hi) + 1, row1);
  if (x0 >= x1 || y0 >= y1) return;
  const std::int64_t px = std::int64_t{x0} * kSubpixels + kSubpixels / 2;
  const std::int64_t py = std::int64_t{y0} * kSubpixels + kSubpixels / 2;
  std::array<Side, 3> sides{Side(t, 0, px, py), Side(t, 1, px, py), Side(t, 2, px, py)};
  // Depth is near / w: linear on the screen.
  const double area = static_cast<double>(std::int64_t{t.x[1] - t.x[0]} * (t.y[2] - t.y[0]) -
                                          std::int64_t{t.y[1] - t.y[0]} * (t.x[2] - t.x[0]));
  const double d0 = double{t.depth[0]};
  const double d1 = (double{t.depth[1]} - d0) / area;
  const double d2 = (double{t.depth[2]} - d0) / area;
  for (int y = y0; y < y1; ++y) {
    std::int64_t a = sides[0].value;  // opposite corner 2
    std::int64_t b = sides[1].value;  // opposite corner 0
    std::int64_t c = sides[2].value;  // opposite corner 1
    std::size_t pixel = static_cast<std::size_t>(y) * static_cast<std::size_t>(out.width) +
                        static_cast<std::size_t>(x0);
    for (int x = x0; x < x1; ++x, ++pixel) {
      if ((a | b | c) >= 0) {
        const auto depth =
            static_cast<float>(d0 + d1 * static_cast<double>(c) + d2 * static_cast<double>(a));
        if (depth > out.depth[pixel]) {
          out.depth[pixel] = depth;
          out.triangle[pixel] = t.number;
        }
      }
      a += sides[0].dx;
      b += sides[1].dx;
      c += sides[2].dx;
    }
    for (Side& s : sides) s.value += s.dy;
  }
}

}  // namespace

Picture rasterise(const mesh::Surface& surface, const Affine2& world_from_post, const View& view,
                  const RasterOptions& options) {
  Picture out;
  out.width = view.viewport_width;
  out.height = view.viewport_height;
  const auto pixels = static_cast<std::size_t>(out.width) * static_cast<std::size_t>(out.height);
  out.depth.assign(pixels, 0.0F);
  out.triangle.assign(pixels, Picture::kNothing);

  constexpr std::size_t kAtOnce = 4096;
  const std::size_t chunks = (surface.triangles() + kAtOnce - 1) / kAtOnce;
  std::vector<std::vector<ScreenTriangle>> triangles(chunks);
  parallel_for(options.threads, static_cast<int>(chunks), [&](int chunk) {
    Setup setup(surface, world_from_post, view, options.sample_shift);
    const auto c = static_cast<std::size_t>(chunk);
    const std::size_t end = std::min((c + 1) * kAtOnce, surface.triangles());
    for (std::size_t i = c * kAtOnce; i < end; ++i) {
      setup.add(static_cast<std::uint32_t>(i), triangles[c]);
    }
  });
  parallel_for(options.threads, (out.height + kBandRows - 1) / kBandRows, [&](int band) {
    const int row0 = band * kBandRows;
    const int row1 = std::min(row0 + kBandRows, out.height);
    for (const auto& chunk : triangles) {
      for (const ScreenTriangle& t : chunk) draw(t, row0, row1, out);
    }
  });
  return out;
}

}  // namespace arete::proof
