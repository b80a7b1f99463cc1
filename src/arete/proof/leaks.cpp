#include "arete/proof/leaks.h"

#include <algorithm>
#include <array>
#include <cassert>

#include "arete/proof/rasteriser.h"

namespace arete::proof {

std::uint64_t background_pixels(std::span<const float> depth, const mesh::Surface& surface,
                                const Affine2& world_from_post, const View& view, int threads) {
  std::vector<std::size_t> suspects;
  for (std::size_t i = 0; i < depth.size(); ++i) {
    if (depth[i] == 0) suspects.push_back(i);
  }
  // The centre first: it clears the sky, and then there is hardly ever anything left.
  constexpr std::array<glm::dvec2, 5> kSamples{
      {{0, 0}, {-0.5, -0.5}, {0.5, -0.5}, {-0.5, 0.5}, {0.5, 0.5}}};
  for (const glm::dvec2 shift : kSamples) {
    if (suspects.empty()) return 0;
    const Picture picture =
        rasterise(surface, world_from_post, view, {.sample_shift = shift, .threads = threads});
    assert(picture.depth.size() == depth.size());
    std::erase_if(suspects, [&](std::size_t i) { return picture.depth[i] == 0; });
  }
  return suspects.size();
}

}  // namespace arete::proof
