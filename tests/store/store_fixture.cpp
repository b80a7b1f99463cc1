#include "store/store_fixture.h"

#include <cmath>
#include <fstream>
#include <iterator>

namespace arete::store {

Heightfield make_hills(int cols, int rows, std::uint32_t seed) {
  Heightfield field(cols, rows);
  std::mt19937 random(seed);
  std::uniform_int_distribution<int> noise(-3, 3);
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < cols; ++c)
      field[{c, r}] = static_cast<float>(
          std::lround(900 * std::sin(0.021 * c) * std::cos(0.017 * r)) + noise(random));
  field.set_lattice({true, 1.0, 0.0});
  return field;
}

void punch_holes(Heightfield& field, int count, std::uint32_t seed) {
  std::mt19937 random(seed);
  const auto below = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
  for (int i = 0; i < count; ++i) {
    const Post corner{below(field.cols()), below(field.rows())};
    const int width = 1 + below(field.cols());
    const int height = 1 + below(field.rows() / 2 + 1);
    for (int r = corner.row; r < std::min(corner.row + height, field.rows()); ++r)
      for (int c = corner.col; c < std::min(corner.col + width, field.cols()); ++c)
        field[{c, r}] = kNoData;
  }
}

std::filesystem::path build_store(const TemporaryFolder& folder, Heightfield& field,
                                  const BuildContext& context) {
  BuildOptions options;
  options.output = folder / "t.arete";
  options.source_key = "test";
  build(field, options, context);
  return options.output;
}

std::map<std::string, std::vector<char>> read_all_files(const std::filesystem::path& folder) {
  std::map<std::string, std::vector<char>> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    std::ifstream in(entry.path(), std::ios::binary);
    files[entry.path().lexically_relative(folder).string()] = {std::istreambuf_iterator<char>(in),
                                                               std::istreambuf_iterator<char>()};
  }
  return files;
}

}  // namespace arete::store
