#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "arete/core/heightfield.h"
#include "arete/store/build.h"

namespace arete::store {

inline constexpr float kNoData = std::numeric_limits<float>::quiet_NaN();

/// A folder that goes with the test.
class TemporaryFolder {
 public:
  TemporaryFolder()
      : path_(std::filesystem::temp_directory_path() /
              ("arete-store-" + std::to_string(std::random_device{}()))) {
    std::filesystem::create_directories(path_);
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// Rolling integer hills with noise; integers, so that the lattice is the unit one.
Heightfield make_hills(int cols, int rows, std::uint32_t seed);
/// Punches `count` rectangular holes.
void punch_holes(Heightfield& field, int count, std::uint32_t seed);
/// Builds with the defaults; returns the store's path.
std::filesystem::path build_store(const TemporaryFolder& folder, Heightfield& field,
                                  const BuildContext& context = {});
/// Every file of a folder by its name relative to it.
std::map<std::string, std::vector<char>> read_all_files(const std::filesystem::path& folder);

}  // namespace arete::store
