#include <algorithm>

#include "arete/store/raster_recipe.h"

namespace arete::store {

RasterRecipe mask_recipe(const PyramidShape& shape) {
  constexpr std::uint8_t kValid = 255;
  RasterRecipe recipe;
  recipe.step = "validity";
  recipe.shape = pyramid_over(shape.cols, shape.rows);
  recipe.shape.fill = kValid;
  recipe.make_texels = [](const HeightPatch& patch, Post post, int cols, std::uint8_t* to) {
    const std::uint8_t* valid = patch.valid(post.row, post.col);
    std::transform(valid, valid + cols, to,
                   [](std::uint8_t v) { return v != 0 ? kValid : std::uint8_t{0}; });
  };
  recipe.mean = [](const std::array<const std::uint8_t*, 4>& from, std::uint8_t* to) {
    *to = static_cast<std::uint8_t>((*from[0] + *from[1] + *from[2] + *from[3] + 2) / 4);
  };
  return recipe;
}

}  // namespace arete::store
