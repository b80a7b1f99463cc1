#include "viewer.h"

#include <algorithm>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <fmt/format.h>

#include "arete/core/error.h"
#include "arete/render/picture.h"

#include "ground.h"
#include "map_camera.h"
#include "pick.h"

namespace arete::app {
namespace {

namespace fs = std::filesystem;

/// NAME-1.EXT, NAME-2.EXT, ...: the first that is not there yet.
fs::path free_name(const std::string& stem, const std::string& extension) {
  for (int i = 1;; ++i) {
    fs::path file = fmt::format("{}-{}{}", stem, i, extension);
    if (!fs::exists(file)) {
      return file;
    }
  }
}

double aspect(FrameSize size) {
  return static_cast<double>(size.width) / size.height;
}

scene::Keyframe keyframe(double t, const Pose& pose) {
  return {t, pose.eye, pose.yaw, pose.pitch, pose.fovy};
}

}  // namespace

Viewer::Viewer(const ViewFlags& flags)
    : flags_(flags),
      terrain_(open_terrain(flags.flight.terrain, {flags.method})),
      ground_(ground_of(*terrain_, store::Fetch::Resident)),
      window_(fmt::format("Arete - {}", flags.flight.terrain.terrain.filename().string()),
              flags.flight.size),
      rasters_(*terrain_),
      shown_(std::make_unique<ShownMethod>(flags.flight.terrain, flags.method, *terrain_,
                                           rasters_.land, flags.flight.gpu_memory.count)),
      controls_(ground_, home_pose(ground_, aspect(flags.flight.size))),
      tolerance_px_(static_cast<float>(flags.flight.refine_options().tolerance_px)) {
  if (!flags.flight.path.empty()) {
    path_ = scene::make_path(flags.flight.path, ground_of(*terrain_, store::Fetch::Wait));
  }
  if (!scripted()) {
    style_.texture_tiles = 8;  // a few milliseconds a frame at most; the rest comes with the next
  }
  if (terrain_->manifest().drawable_cells == 0) {
    message_ = "nothing to draw: no square of four posts has data";
  }
}

void Viewer::run() {
  while (!window_.closed()) {
    show_frame();
    if (scripted() && ++frames_shown_ >= flags_.flight.frames) {
      save_screenshot(flags_.screenshot);
      window_.close();
    }
  }
}

void Viewer::show_frame() {
  window_.begin();
  resize(window_.size());
  act_on_keys();
  move_camera();
  view_ = make_view(controls_.pose(), frame_->width(), frame_->height());
  if (!frozen_ || !shown_->refined()) {
    lod::RefineOptions options = flags_.flight.refine_options();
    options.tolerance_px = static_cast<double>(tolerance_px_);
    options.on_missing = scripted() ? lod::OnMissing::Wait : lod::OnMissing::Defer;
    shown_->refine(view_, options);
  }
  shown_->draw(view_, style_, *frame_);
  draw_panels();
  window_.end(frame_->framebuffer(), {frame_->width(), frame_->height()});
}

void Viewer::resize(FrameSize size) {
  if (!frame_ || frame_->width() != size.width || frame_->height() != size.height) {
    frame_.reset();
    frame_ = std::make_unique<render::Frame>(size.width, size.height);
  }
}

void Viewer::act_on_keys() {
  for (const int key : window_.pressed()) {
    try {
      press(key);
    } catch (const Error& error) {  // a folder that cannot be written ends no flight
      message_ = error.what();
    }
  }
}

void Viewer::press(int key) {
  switch (key) {
    case GLFW_KEY_ESCAPE:
      return window_.close();
    case GLFW_KEY_F:
      return controls_.toggle_fly();
    case GLFW_KEY_H:
      help_ = !help_;
      return;
    case GLFW_KEY_L:
      frozen_ = !frozen_;
      return;
    case GLFW_KEY_M:
      return next_method();
    case GLFW_KEY_P:
      return toggle_recording();
    case GLFW_KEY_SPACE:
      path_.reset();
      return controls_.glide_to(home_pose(ground_, aspect({frame_->width(), frame_->height()})));
    case GLFW_KEY_F12:
      return save_screenshot(free_name("arete", ".png"));
    case GLFW_KEY_W:
      style_.wireframe = style_.wireframe != (controls_.mode() == ControlMode::Map);
      return;
    default:
      return;
  }
}

void Viewer::next_method() {
  const std::vector<std::string>& held = terrain_->manifest().methods;
  const auto now = std::ranges::find(held, shown_->name());
  if (held.size() < 2) {
    message_ = "the store holds no other method: build it with --methods all";
    return;
  }
  const std::string next = now == held.end() || now + 1 == held.end() ? held.front() : *(now + 1);
  try {
    auto shown = std::make_unique<ShownMethod>(flags_.flight.terrain, next, *terrain_,
                                               rasters_.land, flags_.flight.gpu_memory.count);
    shown_ = std::move(shown);
    message_.clear();
  } catch (const Error& error) {
    message_ = error.what();
  }
}

void Viewer::toggle_recording() {
  if (path_) {
    path_.reset();
    message_ = "replay stopped";
  } else if (!recording_) {
    recording_.emplace();
    recorded_seconds_ = 0;
    message_ = "recording a path: P saves and replays it";
  } else {
    if (recording_->empty() || recorded_seconds_ > recording_->back().t) {
      recording_->push_back(keyframe(recorded_seconds_, controls_.pose()));
    }
    path_.emplace(std::move(*recording_));
    path_seconds_ = 0;
    recording_.reset();
    const fs::path file = free_name("path", ".json");
    scene::write_path(*path_, file);
    message_ = fmt::format("replaying {}: P stops", file.string());
  }
}

void Viewer::move_camera() {
  constexpr double kKeyframeSeconds = 0.25;
  const Input input = window_.input();
  times_.add(static_cast<float>(input.seconds * 1000));
  if (path_) {
    return follow_path(input.seconds);
  }
  controls_.update(input, {frame_->width(), frame_->height()});
  if (recording_) {
    recorded_seconds_ += input.seconds;
    if (recording_->empty() || recorded_seconds_ - recording_->back().t >= kKeyframeSeconds) {
      recording_->push_back(keyframe(recorded_seconds_, controls_.pose()));
    }
  }
}

void Viewer::follow_path(double seconds) {
  if (scripted()) {
    path_seconds_ = instant(*path_, frames_shown_, flags_.flight.frames);
  } else {
    path_seconds_ += seconds;
  }
  controls_.set_pose(path_->at(std::min(path_seconds_, path_->duration())));
  if (!scripted() && path_seconds_ >= path_->duration()) {
    path_.reset();
    message_ = "end of the path";
  }
}

std::optional<glm::dvec3> Viewer::under_cursor() const {
  const auto world = ground_along(ground_, view_.eye, cursor_ray(view_, window_.cursor()));
  if (!world) {
    return std::nullopt;
  }
  const Georef& georef = terrain_->manifest().georef;
  const glm::dvec2 post = georef.world_from_post.inverse(glm::dvec2(*world));
  return glm::dvec3(georef.crs_from_post.apply(post.x, post.y), world->z);
}

void Viewer::draw_panels() {
  const glm::dvec3 eye = view_.eye;
  draw_overlay({shown_->name(), controls_.mode() == ControlMode::Map ? "map" : "fly", message_,
                shown_->refine_stats(), shown_->draw_stats(), terrain_->cache_stats(),
                flags_.flight.terrain.cache.count, flags_.flight.gpu_memory.count, under_cursor(),
                eye.z - ground_height(ground_, glm::dvec2(eye)), frozen_},
               times_, tolerance_px_);
  if (help_) {
    draw_help();
  }
}

void Viewer::save_screenshot(const fs::path& file) {
  render::write_png(file, frame_->width(), frame_->height(), frame_->read_rgb());
  message_ = fmt::format("saved {}", file.string());
}

}  // namespace arete::app
