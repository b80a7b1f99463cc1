#include <algorithm>

#include "arete/store/height_window.h"
#include "arete/store/recipes.h"

namespace arete::store {

RasterRecipe mask_recipe(const PyramidShape& shape, const TileReader& read) {
  constexpr std::uint8_t kValid = 255;
  RasterRecipe recipe;
  recipe.step = "validity";
  recipe.shape = pyramid_over(shape.cols, shape.rows);
  recipe.shape.fill = kValid;
  recipe.bytes_each = HeightWindow::bytes(shape.cols, kTexelTile);
  recipe.make_row = [shape, &read](int y, const auto& keep) {
    thread_local HeightWindow window;
    window.load(shape, y * kTexelTile, kTexelTile, read);
    Texels texels{kTexelTile, 1, std::vector<std::uint8_t>(kTexelTile * kTexelTile)};
    const int rows = std::min(kTexelTile, shape.rows - y * kTexelTile);
    for (int x = 0; x * kTexelTile < shape.cols; ++x) {
      const int cols = std::min(kTexelTile, shape.cols - x * kTexelTile);
      for (int r = 0; r < rows; ++r)
        std::transform(window.valid_row(r) + x * kTexelTile,
                       window.valid_row(r) + x * kTexelTile + cols,
                       texels.bytes.begin() + r * kTexelTile,
                       [](std::uint8_t v) { return v != 0 ? kValid : std::uint8_t{0}; });
      keep(x, texels);
    }
  };
  recipe.mean = [](const std::array<const std::uint8_t*, 4>& from, std::uint8_t* to) {
    *to = static_cast<std::uint8_t>((*from[0] + *from[1] + *from[2] + *from[3] + 2) / 4);
  };
  return recipe;
}

}  // namespace arete::store
