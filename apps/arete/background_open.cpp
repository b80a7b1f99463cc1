#include "background_open.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "arete/core/error.h"
#include "arete/raster/dem.h"

#include "recipe.h"
#include "thinned_rows.h"

namespace arete::app {
namespace {

namespace fs = std::filesystem;

constexpr int kPreviewPosts = 1024;  // a side

class TemporaryDirectory {
 public:
  TemporaryDirectory() : path_((fs::temp_directory_path() / "arete-preview-XXXXXX").string()) {
    if (mkdtemp(path_.data()) == nullptr) {
      throw Error(ErrorCode::Io, fmt::format("{}: cannot be made: set TMPDIR", path_));
    }
  }
  ~TemporaryDirectory() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  TemporaryDirectory(const TemporaryDirectory&) = delete;
  TemporaryDirectory& operator=(const TemporaryDirectory&) = delete;
  fs::path path() const { return path_; }

 private:
  std::string path_;
};

std::string method_of(const store::Terrain& terrain, const std::string& wanted) {
  const std::vector<std::string>& held = terrain.manifest().methods;
  return held.empty() || std::ranges::count(held, wanted) != 0 ? wanted : held.front();
}

// Nothing for a DEM that is small enough to wait for.
std::optional<OpenedTerrain> open_preview(const TerrainFlags& flags, const std::string& method,
                                          const BuildProgress& progress) {
  Recipe recipe;
  recipe.dems = {flags.terrain};
  recipe.methods = {method};
  recipe.method_flags = flags.method_flags;
  recipe.progress = progress;
  const auto source = raster::open_dem(recipe.dems, recipe.dem);
  const int longest = std::max(source->cols(), source->rows());
  if (longest <= kPreviewPosts) {
    return std::nullopt;
  }
  ThinnedRows thinned(*source, (longest + kPreviewPosts - 1) / kPreviewPosts);
  const TemporaryDirectory directory;  // files that are open need no name
  const fs::path store = directory.path() / "preview.arete";
  build_quietly(recipe, thinned, store);
  OpenedTerrain opened = open_with_method(flags, store, method);
  opened.preview = true;
  return opened;
}

}  // namespace

BackgroundOpen::BackgroundOpen(TerrainFlags flags, std::string method)
    : flags_(std::move(flags)), method_(std::move(method)), thread_([this] { run(); }) {}

BackgroundOpen::~BackgroundOpen() {
  cancelled_ = true;
}

BackgroundOpen::Progress BackgroundOpen::progress() const {
  const std::scoped_lock lock(mutex_);
  return progress_;
}

std::optional<OpenedTerrain> BackgroundOpen::take() {
  const std::scoped_lock lock(mutex_);
  return std::exchange(ready_, std::nullopt);
}

std::exception_ptr BackgroundOpen::failure() const {
  const std::scoped_lock lock(mutex_);
  return failure_;
}

bool BackgroundOpen::tell(std::string_view step, double done) {
  const std::scoped_lock lock(mutex_);
  progress_ = {std::string(step), done};
  return !cancelled_;
}

void BackgroundOpen::offer(OpenedTerrain opened) {
  const std::scoped_lock lock(mutex_);
  ready_ = std::move(opened);
}

void BackgroundOpen::run() {
  try {
    const BuildProgress progress = [this](std::string_view step, double done) {
      return tell(step, done);
    };
    auto store = ready_store(flags_, {method_});
    if (!store) {
      const auto preview_progress = [this](std::string_view, double done) {
        return tell("preview", done);
      };
      if (auto preview = open_preview(flags_, method_, preview_progress)) {
        offer(std::move(*preview));
      }
      store = store_of(flags_, {method_}, progress);
    }
    const std::string method = method_of(*open_store(flags_, *store), method_);
    offer(open_with_method(flags_, *store, method));
  } catch (...) {
    const std::scoped_lock lock(mutex_);
    failure_ = std::current_exception();
  }
  finished_ = true;
}

}  // namespace arete::app
