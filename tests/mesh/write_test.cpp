#include "arete/mesh/write.h"

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "arete/core/error.h"

#include "mesh/toy_surface.h"

namespace arete::mesh {
namespace {

class WriteMesh : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(::testing::TempDir()) /
              ::testing::UnitTest::GetInstance()->current_test_info()->name();
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string written(const std::string& name) {
    write_mesh(folder_ / name, surface_, options_);
    return read(name);
  }
  std::string read(const std::string& name) {
    std::ifstream in(folder_ / name, std::ios::binary);
    std::stringstream text;
    text << in.rdbuf();
    return text.str();
  }
  std::size_t files() const {
    return static_cast<std::size_t>(
        std::distance(std::filesystem::directory_iterator(folder_), {}));
  }

  // Two batches that share an edge but no vertex: 9 places, 8 triangles.
  static Surface two_batches(const Heightfield& dem) {
    Surface s;
    for (const toy::Triangle& t : toy::all_cells(3, 3)) {
      for (const Post p : t) {
        s.indices.push_back(static_cast<std::uint32_t>(s.vertices.size()));
        s.vertices.push_back({p, 0, 0, dem[p]});
      }
    }
    return s;
  }

  std::filesystem::path folder_;
  Heightfield dem_ = toy::hills(3, 3);
  Surface surface_ = two_batches(dem_);
  WriteOptions options_{.world_from_post = {{10, 0, 0, 0, -10, 0}}, .keep = {}};
};

template <typename T>
T at(const std::string& bytes, std::size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

TEST_F(WriteMesh, ObjMergesVerticesAndUsesWorldMetres) {
  const std::string text = written("a.obj");
  EXPECT_EQ(std::ranges::count(text, 'v'), 9);
  EXPECT_EQ(std::ranges::count(text, 'f'), 8);
  EXPECT_NE(text.find(fmt::format("v 20.0000 -20.0000 {:.4f}\n", dem_[{2, 2}])), std::string::npos);
  EXPECT_EQ(files(), 1U);
}

TEST_F(WriteMesh, PlyHoldsWhatItsHeaderSays) {
  const std::string bytes = written("a.ply");
  EXPECT_NE(bytes.find("element vertex 9\n"), std::string::npos);
  EXPECT_NE(bytes.find("element face 8\n"), std::string::npos);
  const std::size_t body = bytes.find("end_header\n") + 11;
  EXPECT_EQ(bytes.size(), body + 9 * 12 + 8 * 13);
}

TEST_F(WriteMesh, GridPlyIsInPostsAndExact) {
  surface_.vertices[0].dcol = 0.25F;
  write_grid_ply(folder_ / "a.ply", surface_);
  const std::string bytes = read("a.ply");
  const std::size_t body = bytes.find("end_header\n") + 11;
  EXPECT_EQ(at<float>(bytes, body), 0.25F);
  EXPECT_EQ(at<float>(bytes, body + 4), 0.0F);
  EXPECT_EQ(at<float>(bytes, body + 8), (dem_[{0, 0}]));
}

TEST_F(WriteMesh, StlNormalsPointUp) {
  const std::string bytes = written("a.stl");
  ASSERT_EQ(bytes.size(), 84U + 8 * 50);
  EXPECT_EQ(at<std::uint32_t>(bytes, 80), 8U);
  for (std::size_t f = 0; f < 8; ++f) EXPECT_GT(at<float>(bytes, 84 + 50 * f + 8), 0);
}

TEST_F(WriteMesh, GlbIsWellFormed) {
  const std::string bytes = written("a.glb");
  EXPECT_EQ(bytes.substr(0, 4), "glTF");
  EXPECT_EQ(at<std::uint32_t>(bytes, 8), bytes.size());
  const std::size_t json = at<std::uint32_t>(bytes, 12);
  EXPECT_EQ(json % 4, 0U);
  EXPECT_EQ(bytes.substr(16, 4), "JSON");
  EXPECT_EQ(at<std::uint32_t>(bytes, 20 + json), 9U * 12 + 24 * 4);
  EXPECT_EQ(bytes.substr(24 + json, 3), "BIN");
  EXPECT_EQ(bytes.size(), 28 + json + 9 * 12 + 24 * 4);
}

TEST_F(WriteMesh, DropsTrianglesByTheirPosts) {
  options_.keep = [](const std::array<Post, 3>& t) {
    return std::ranges::none_of(t, [](Post p) { return p == Post{0, 0}; });
  };
  const MeshSize size = write_mesh(folder_ / "a.obj", surface_, options_);
  EXPECT_EQ(size.triangles, 6U);
  EXPECT_EQ(size.vertices, 8U);
  const std::string text = read("a.obj");
  EXPECT_EQ(std::ranges::count(text, 'f'), 6);
  EXPECT_EQ(std::ranges::count(text, 'v'), 8);
}

TEST_F(WriteMesh, LeavesNothingBehindOnFailure) {
  EXPECT_THROW(write_mesh(folder_ / "a.fbx", surface_, options_), Error);
  EXPECT_THROW(write_mesh(folder_ / "none" / "a.obj", surface_, options_), Error);
  EXPECT_THROW(write_mesh(folder_ / "a.obj", {}, options_), Error);
  std::filesystem::create_directories(folder_ / "a.ply" / "full");
  EXPECT_THROW(write_mesh(folder_ / "a.ply", surface_, options_), Error);
  EXPECT_EQ(files(), 1U);
}

}  // namespace
}  // namespace arete::mesh
