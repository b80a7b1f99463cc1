#include "arete/raster/synthetic.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "arete/core/error.h"

namespace arete::raster {
namespace {

constexpr double kSpacingM = 30;
constexpr float kHighestM = 3000;
constexpr int kFinestCell = 2;

// splitmix64 finaliser: every bit of the key moves every bit of the hash.
std::uint64_t mix(std::uint64_t x) {
  x = (x ^ (x >> 30U)) * 0xBF58476D1CE4E5B9ULL;
  x = (x ^ (x >> 27U)) * 0x94D049BB133111EBULL;
  return x ^ (x >> 31U);
}

struct Gradient {
  float x, y;  ///< in [-1, 1]
};

Gradient gradient_at(std::uint64_t seed, int ix, int iy) {
  const std::uint64_t key =
      (std::uint64_t{static_cast<std::uint32_t>(iy)} << 32U) | static_cast<std::uint32_t>(ix);
  const std::uint64_t h = mix(seed ^ mix(key + 0x9E3779B97F4A7C15ULL));
  const auto part = [](std::uint64_t bits) {
    return static_cast<float>(static_cast<std::int32_t>(bits & 0xFFFFU) - 0x8000) / 0x8000;
  };
  return {part(h), part(h >> 32U)};
}

// Quintic fade: second derivatives agree across cells.
float fade(float t) {
  return t * t * t * (t * (t * 6 - 15) + 10);
}

// One octave of gradient noise on square lattice cells of `cell` posts, shifted by (ox, oy) so that
// the zeros of the octaves do not fall together.
class Octave {
 public:
  Octave(std::uint64_t seed, int cell)
      : seed_(mix(seed ^ static_cast<std::uint64_t>(cell))), cell_(cell) {
    const auto side = static_cast<std::uint64_t>(cell);
    ox_ = static_cast<int>(mix(seed_ + 1) % side);
    oy_ = static_cast<int>(mix(seed_ + 2) % side);
  }

  int cell() const { return cell_; }

  // Noise of row r, about [-1, 1]. A cell's row is lerp(west + west_x fx, east + east_x (fx - 1))
  // because the lerp across rows can be taken of the gradients.
  void fill(int r, std::vector<float>& out) const {
    const int count = static_cast<int>(out.size());
    const int iy = (r + oy_) / cell_;
    const float fy = (static_cast<float>((r + oy_) % cell_) + 0.5F) / static_cast<float>(cell_);
    const float v = fade(fy);
    Edge west = edge(0, iy, fy, v);
    for (int ix = 0; ix * cell_ - ox_ < count; ++ix) {
      const Edge east = edge(ix + 1, iy, fy, v);
      fill_cell(ix * cell_ - ox_, west, east, out);
      west = east;
    }
  }

 private:
  struct Edge {
    float level, slope;
  };

  Edge edge(int ix, int iy, float fy, float v) const {
    const Gradient north = gradient_at(seed_, ix, iy);
    const Gradient south = gradient_at(seed_, ix, iy + 1);
    return {north.y * fy * (1 - v) + south.y * (fy - 1) * v, north.x * (1 - v) + south.x * v};
  }

  void fill_cell(int start, Edge west, Edge east, std::vector<float>& out) const {
    const int first = std::max(start, 0);
    const int end = std::min(start + cell_, static_cast<int>(out.size()));
    const float scale = 1 / static_cast<float>(cell_);
    for (int c = first; c < end; ++c) {
      const float fx = (static_cast<float>(c - start) + 0.5F) * scale;
      const float u = fade(fx);
      const float w = west.level + west.slope * fx;
      const float e = east.level + east.slope * (fx - 1);
      out[static_cast<std::size_t>(c)] = w + u * (e - w);
    }
  }

  std::uint64_t seed_;
  int cell_;
  int ox_, oy_;
};

class Synthetic final : public HeightSource {
 public:
  Synthetic(SyntheticKind kind, int size, std::uint64_t seed) : kind_(kind), size_(size) {
    const double extent = kSpacingM * std::max(1, size - 1);
    relief_ = std::min(kHighestM, static_cast<float>(0.1 * extent));
    const auto widest = std::bit_floor(static_cast<unsigned>(std::max(kFinestCell, size / 2)));
    for (int cell = static_cast<int>(widest); cell >= kFinestCell; cell /= 2) {
      octaves_.emplace_back(mix(seed), cell);
    }
    noise_.resize(static_cast<std::size_t>(size));
  }

  int cols() const override { return size_; }
  int rows() const override { return size_; }

  Georef georef() const override {
    Georef georef;
    georef.world_from_post = georef.crs_from_post = Affine2{{kSpacingM, 0, 0, 0, -kSpacingM, 0}};
    return georef;
  }

  std::string description() const override {
    constexpr std::string_view kNames[] = {"fbm", "ridged", "terraces", "flat", "slope"};
    return fmt::format("synthetic {} ({} x {})", kNames[static_cast<int>(kind_)], size_, size_);
  }

  void read_row(int r, std::span<float> row) override {
    std::fill(row.begin(), row.end(), 0.0F);
    switch (kind_) {
      case SyntheticKind::Flat:
        return;
      case SyntheticKind::Slope:
        return slope(r, row);
      case SyntheticKind::Ridged:
        return ridged(r, row);
      case SyntheticKind::Fbm:
        return fbm(r, row);
      case SyntheticKind::Terraces:
        fbm(r, row);
        return cut_terraces(row);
    }
  }

 private:
  // Climbs to the north-east, twice as steep to the east; not a plane of the lattice's diagonals.
  void slope(int r, std::span<float> row) const {
    const float step = relief_ / static_cast<float>(3 * std::max(1, size_ - 1));
    for (int c = 0; c < size_; ++c) {
      row[static_cast<std::size_t>(c)] = step * static_cast<float>(2 * c + size_ - 1 - r);
    }
  }

  // Fractional Brownian motion with H = 1: half the amplitude an octave.
  void fbm(int r, std::span<float> row) {
    float amplitude = relief_ * 0.7F;
    for (const Octave& octave : octaves_) {
      octave.fill(r, noise_);
      for (std::size_t c = 0; c < row.size(); ++c) row[c] += amplitude * noise_[c];
      amplitude *= 0.5F;
    }
    for (float& z : row) z += relief_ * 0.5F;
  }

  // Ridged multifractal: the crease of |noise| turned up, finer ones only where coarser are high.
  void ridged(int r, std::span<float> row) {
    weight_.assign(row.size(), 1.0F);
    float amplitude = relief_ * 0.5F;
    for (const Octave& octave : octaves_) {
      octave.fill(r, noise_);
      for (std::size_t c = 0; c < row.size(); ++c) {
        const float crest = 1 - std::min(1.0F, 1.6F * std::abs(noise_[c]));
        const float signal = crest * crest * weight_[c];
        row[c] += amplitude * signal;
        weight_[c] = std::min(1.0F, 1.5F * signal);
      }
      amplitude *= 0.5F;
    }
  }

  // Treads with a slight tilt and risers over a sixth of each step.
  void cut_terraces(std::span<float> row) const {
    const float step = relief_ / 16;
    for (float& z : row) {
      const float level = std::floor(z / step);
      const float within = z / step - level;
      const float riser = fade(std::clamp((within - 0.5F) * 6 + 0.5F, 0.0F, 1.0F));
      z = step * (level + 0.1F * within + 0.9F * riser);
    }
  }

  SyntheticKind kind_;
  int size_;
  float relief_ = 0;
  std::vector<Octave> octaves_;
  std::vector<float> noise_, weight_;
};

}  // namespace

std::unique_ptr<HeightSource> synthesize(SyntheticKind kind, int size, std::uint64_t seed) {
  if (size < 1 || size > (1 << 24)) {
    throw Error(ErrorCode::Usage,
                fmt::format("synthetic terrain: a side of {} posts: 1 to 2^24 are made", size));
  }
  return std::make_unique<Synthetic>(kind, size, seed);
}

}  // namespace arete::raster
