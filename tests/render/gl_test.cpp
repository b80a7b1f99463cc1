#include "render/gl_test.h"

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <string>

#include "arete/core/error.h"
#include "arete/render/headless.h"

namespace arete::render {
namespace {

// The reason why there is no context; empty when there is one.
const std::string& context_failure() {
  static std::unique_ptr<HeadlessContext> context;
  static const std::string failure = [] {
    try {
      context = std::make_unique<HeadlessContext>();
      return std::string();
    } catch (const Error& e) {
      return std::string(e.what());
    }
  }();
  return failure;
}

}  // namespace

void GlTest::SetUp() {
  if (!context_failure().empty()) GTEST_SKIP() << context_failure();
}

Picture shoot(Renderer& renderer, const View& view, const DrawList& list, const BlockSource& blocks,
              const Style& style) {
  Frame frame(view.viewport_width, view.viewport_height);
  renderer.draw(view, list, blocks, style, frame);
  return frame.read_rgb();
}

int different_pixels(const Picture& a, const Picture& b, int tolerance) {
  EXPECT_EQ(a.size(), b.size());
  int count = 0;
  for (std::size_t i = 0; i + 2 < a.size(); i += 3) {
    const bool differs = std::abs(a[i] - b[i]) > tolerance ||
                         std::abs(a[i + 1] - b[i + 1]) > tolerance ||
                         std::abs(a[i + 2] - b[i + 2]) > tolerance;
    count += differs ? 1 : 0;
  }
  return count;
}

}  // namespace arete::render
