#include "viewer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <fmt/format.h>

#include "arete/core/error.h"
#include "arete/render/picture.h"

#include "ground.h"
#include "interrupt.h"
#include "map_camera.h"
#include "pick.h"

namespace arete::app {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;

const Clock::time_point kProgramStart = Clock::now();

constexpr int kTextureTiles = 8;   // a frame: a few milliseconds at most
constexpr int kFramesToRest = 20;  // without any change, before the viewer waits for events
constexpr double kToldSeconds = 8;

bool same_pose(const Pose& a, const Pose& b) {
  return a.eye == b.eye && a.yaw == b.yaw && a.pitch == b.pitch && a.fovy == b.fovy;
}

// Nothing when the terrain is a DEM that must be built first. A film is not begun without its land.
std::optional<OpenedTerrain> open_at_once(const ViewFlags& flags) {
  const TerrainFlags& terrain = flags.flight.terrain;
  const std::vector<std::string> methods{flags.method};
  const auto store = flags.screenshot.empty() ? ready_store(terrain, methods)
                                              : std::optional(store_of(terrain, methods));
  if (!store) {
    return std::nullopt;
  }
  return open_with_method(terrain, *store, flags.method);
}

std::string_view name_of(ControlMode mode) {
  return mode == ControlMode::Map ? "map" : "fly";
}

}  // namespace

Viewer::Viewer(const ViewFlags& flags)
    : flags_(flags), first_(open_at_once(flags)), window_("Arete", flags.flight.size) {
  if (!flags.trace.empty()) {
    log_.emplace(flags.trace);
  }
  knobs_.tolerance_px = static_cast<float>(flags.flight.refine_options().tolerance_px);
  knobs_.cache_mib = static_cast<int>(flags.flight.terrain.cache.count >> 20U);
  if (flags.flight.triangles < static_cast<std::uint64_t>(Knobs::kAllTriangles)) {
    knobs_.triangles = static_cast<int>(flags.flight.triangles);
  }
  knobs_.gpu_mib = static_cast<int>(flags.flight.gpu_memory.count >> 20U);
  if (first_) {
    show(std::move(*first_));
  } else {
    open(flags.flight.terrain.terrain);
  }
}

void Viewer::run() {
  while (!window_.closed() && !interrupted()) {
    show_frame();
    if (scripted() && ++frames_shown_ >= flags_.flight.frames) {
      save_screenshot(flags_.screenshot);
      window_.close();
    }
  }
  opening_.reset();
  if (failure_) {
    std::rethrow_exception(failure_);
  }
}

// What is shown stays until there is something else to show.
void Viewer::open(const fs::path& terrain) {
  opening_.reset();
  reopen_ = false;
  TerrainFlags flags = flags_.flight.terrain;
  flags.terrain = opening_file_ = terrain;
  const std::string& method = shown_ ? shown_->method() : flags_.method;
  opening_ = std::make_unique<BackgroundOpen>(flags, method);
}

void Viewer::take_opened() {
  if (!window_.dropped().empty()) {
    open(window_.dropped().front());
  }
  if (!opening_) {
    return;
  }
  const bool finished = opening_->finished();  // asked first: nothing comes after it
  if (auto opened = opening_->take()) {
    show(std::move(*opened));
  }
  if (finished) {
    take_failure();
    opening_.reset();
    if (std::exchange(reopen_, false) && shown_) {
      open(shown_->source());
    }
  }
}

void Viewer::take_failure() {
  const std::exception_ptr failure = opening_->failure();
  if (!failure) {
    return;
  }
  if (opening_file_ == flags_.flight.terrain.terrain) {
    failure_ = failure;
    if (!shown_) {
      window_.close();
    }
  }
  try {
    std::rethrow_exception(failure);
  } catch (const std::exception& error) {
    tell(error.what(), Mood::Failure);
  }
}

// A preview and its store are the same land: the camera stays.
void Viewer::show(OpenedTerrain opened) {
  const bool same = shown_ && shown_->source() == opened.source;
  shown_.reset();  // two renderers at once would exceed the cap on GPU memory
  shown_ = std::make_unique<ShownTerrain>(std::move(opened), memory_beside_picture());
  if (!same) {
    controls_.emplace(shown_->ground(), home_pose(shown_->ground(), aspect()));
    path_ = PathRecorder();
    if (!flags_.flight.path.empty()) {
      path_.load(scene::make_path(flags_.flight.path, shown_->ground()));
    }
  }
  controls_->stand_on(shown_->ground());
  window_.set_title(fmt::format("Arete - {}", shown_->source().filename().string()));
  frozen_ = false;
  notice_ = {};
  take_budget();
  if (shown_->terrain().manifest().drawable_cells == 0) {
    tell("nothing to draw: no square of four posts has data", Mood::Failure);
  }
}

void Viewer::show_frame() {
  window_.begin(seconds_to_wait());
  resize(window_.size());
  take_opened();
  act_on_keys();
  if (shown_) {
    show_land();
  }
  draw_notices(notices());
  if (help_) {
    draw_help();
  }
  window_.end(shown_ ? frame_->framebuffer() : 0, {frame_->width(), frame_->height()});
  if (shown_) {
    log_frame();
  }
}

void Viewer::show_land() {
  const glm::dvec3& eye = controls_->pose().eye;
  move_camera();
  above_ground_ = eye.z - height_below(shown_->ground(), eye);
  draw_land();
  look_under_cursor();
  draw_panel();
}

// The first picture of a terrain is whole; later ones fill in as tiles come.
void Viewer::draw_land() {
  const bool whole = scripted() || !shown_->refined();
  view_ = make_view(controls_->pose(), frame_->width(), frame_->height());
  style_.texture_tiles = whole ? std::numeric_limits<int>::max() : kTextureTiles;
  if (!frozen_ || !shown_->refined()) {
    lod::RefineOptions options = flags_.flight.refine_options();
    options.tolerance_px = static_cast<double>(knobs_.tolerance_px);
    options.budget = *budget_;
    // The slider's end: no limit but one of the command line that lies beyond it.
    const std::uint64_t given = flags_.flight.triangles;
    constexpr auto kEnd = static_cast<std::uint64_t>(Knobs::kAllTriangles);
    options.budget.triangles = given >= kEnd ? given : lod::Budget::kUnlimited;
    if (knobs_.triangles < Knobs::kAllTriangles) {
      options.budget.triangles =
          std::max(static_cast<std::uint64_t>(knobs_.triangles), shown_->least_budget().triangles);
    }
    options.on_missing = whole ? lod::OnMissing::Wait : lod::OnMissing::Defer;
    shown_->refine(view_, options);
  }
  shown_->draw(view_, style_, *frame_);
}

void Viewer::resize(FrameSize size) {
  if (!frame_ || frame_->width() != size.width || frame_->height() != size.height) {
    frame_.reset();
    frame_ = std::make_unique<render::Frame>(size.width, size.height);
  }
}

double Viewer::aspect() const {
  const FrameSize size = window_.size();
  return static_cast<double>(size.width) / size.height;
}

// While nothing has changed for some frames events are waited for, and the machine is idle: shortly
// while a store is being built, so that the build has the machine and its progress is seen.
double Viewer::seconds_to_wait() {
  constexpr double kRestSeconds = 0.25, kBuildSeconds = 0.05;
  if (!shown_) {
    return kBuildSeconds;
  }
  const bool moving = window_.touched() || scripted() || path_.replaying() || path_.recording() ||
                      !same_pose(controls_->pose(), drawn_from_) ||
                      shown_->refine_stats().late_blocks != 0 ||
                      shown_->draw_stats().texture_tiles != 0;
  drawn_from_ = controls_->pose();
  frames_at_rest_ = moving ? 0 : frames_at_rest_ + 1;
  if (frames_at_rest_ <= kFramesToRest) {
    return 0;
  }
  return opening_ ? kBuildSeconds : kRestSeconds;
}

void Viewer::act_on_keys() {
  for (const KeyPress& key : window_.pressed()) {
    try {
      press(key);
    } catch (const Error& error) {  // a folder that cannot be written ends no flight
      tell(error.what(), Mood::Failure);
    }
  }
}

void Viewer::press(const KeyPress& press) {
  if (press.key == GLFW_KEY_ESCAPE && !help_) {
    window_.close();
  } else if (press.key == GLFW_KEY_ESCAPE || press.key == GLFW_KEY_H) {
    help_ = !help_;
  } else if (shown_) {
    press_over_land(press);
  }
}

void Viewer::press_over_land(const KeyPress& press) {
  constexpr float kStep = 1.25F;
  switch (press.key) {
    case GLFW_KEY_F:
      return controls_->toggle_fly();
    case GLFW_KEY_L:
      frozen_ = !frozen_;
      return;
    case GLFW_KEY_M:
      return next_method();
    case GLFW_KEY_P:
      return press_path_key(press.shift);
    case GLFW_KEY_SPACE:
      return go_home();
    case GLFW_KEY_F12:
      return save_screenshot(free_name("arete", ".png"));
    case GLFW_KEY_W:
      style_.wireframe = style_.wireframe != (controls_->mode() == ControlMode::Map);
      return;
    case GLFW_KEY_EQUAL:
    case GLFW_KEY_KP_ADD:
    case GLFW_KEY_PAGE_UP:
      return set_tolerance(knobs_.tolerance_px / kStep);
    case GLFW_KEY_MINUS:
    case GLFW_KEY_KP_SUBTRACT:
    case GLFW_KEY_PAGE_DOWN:
      return set_tolerance(knobs_.tolerance_px * kStep);
    default:
      return;
  }
}

void Viewer::set_tolerance(float pixels) {
  knobs_.tolerance_px = std::clamp(pixels, 0.1F, 32.0F);
  tell(fmt::format("tolerance {:.2f} px", knobs_.tolerance_px));
}

void Viewer::change_method(const std::string& method) {
  try {
    shown_->change_method(flags_.flight.terrain, method);
    take_budget();
    tell(fmt::format("method {}", method));
  } catch (const Error& error) {
    tell(error.what(), Mood::Failure);
  }
}

// The picture's size is the user's to change, so the renderer is left a half in any case.
std::size_t Viewer::memory_beside_picture() const {
  const std::size_t all = flags_.flight.gpu_memory.count;
  const FrameSize size = window_.size();
  const std::uint64_t picture = render::Frame::bytes(size.width, size.height);
  return all - std::min<std::size_t>(picture, all / 2);
}

// At open a budget that not even the coarsest surface fits is an error; later it is one that is
// overstepped by as little as can be.
void Viewer::take_budget() {
  try {
    budget_ = shown_->budget_under(flags_.flight);
  } catch (const Error& error) {
    if (!budget_) {
      throw;
    }
    budget_ = shown_->least_budget();
    tell(error.what(), Mood::Failure);
  }
}

// Other budgets are another opening of the same terrain; the camera stays.
void Viewer::change_memory() {
  const auto set = [](Bytes& bytes, int mib) {  // what was not moved stays as given, to the byte
    const auto wanted = static_cast<std::size_t>(mib);
    if (bytes.count >> 20U != wanted) {
      bytes.count = wanted << 20U;
    }
  };
  set(flags_.flight.terrain.cache, knobs_.cache_mib);
  set(flags_.flight.gpu_memory, knobs_.gpu_mib);
  if (opening_) {
    reopen_ = true;  // what is being opened has the old cache
  } else {
    open(shown_->source());
  }
}

void Viewer::next_method() {
  const std::vector<std::string>& held = shown_->terrain().manifest().methods;
  const auto now = std::ranges::find(held, shown_->method());
  if (held.size() < 2) {
    return tell("the store holds no other method: build it with --methods all");
  }
  change_method(now == held.end() || now + 1 == held.end() ? held.front() : *(now + 1));
}

void Viewer::press_path_key(bool shift) {
  if (path_.holds_path() && !path_.recording() && !shift) {
    path_.toggle_replay();
    tell(path_.replaying() ? "replaying the path: P stops" : "replay stopped");
  } else {
    tell(path_.toggle_recording(controls_->pose()));
  }
}

void Viewer::go_home() {
  path_.stop();
  controls_->glide_to(home_pose(shown_->ground(), aspect()));
}

void Viewer::move_camera() {
  const Input input = window_.input();
  if (path_.replaying()) {
    controls_->set_pose(scripted() ? path_.instant(frames_shown_, flags_.flight.frames)
                                   : path_.replay(input.seconds));
    return;
  }
  controls_->update(input, {frame_->width(), frame_->height()});
  path_.record(controls_->pose(), input.seconds);
}

// A ray through the heights in memory: only when another point may lie under the cursor.
void Viewer::look_under_cursor() {
  const auto cursor = window_.cursor();
  const bool same = cursor == looked_at_ && same_pose(looked_from_, controls_->pose()) &&
                    shown_->refine_stats().late_blocks == 0 && frames_at_rest_ > 0;
  if (same) {
    return;
  }
  looked_at_ = cursor;
  looked_from_ = controls_->pose();
  under_cursor_.reset();
  if (cursor) {
    under_cursor_ = ground_along(shown_->cursor_ground(), view_.eye, cursor_ray(view_, *cursor));
  }
}

std::string Viewer::place_text() const {
  if (!under_cursor_) {
    return looked_at_ ? "in the sky" : "-";
  }
  const glm::dvec2 world(*under_cursor_);
  return fmt::format("{}\n{:.1f} m high", shown_->place().text(world),
                     ground_height(shown_->cursor_ground(), world));
}

void Viewer::draw_panel() {
  const Wishes wishes = draw_overlay(
      {shown_->method(), name_of(controls_->mode()), shown_->terrain().manifest().methods,
       shown_->refine_stats(), shown_->draw_stats(), shown_->terrain().cache_stats(),
       shown_->bytes(),
       shown_->draw_stats().gpu_bytes + render::Frame::bytes(frame_->width(), frame_->height()),
       flags_.flight.terrain.cache.count, flags_.flight.gpu_memory.count, place_text(),
       above_ground_, frozen_, style_.wireframe},
      times_, knobs_);
  if (wishes.method) {
    change_method(*wishes.method);
  }
  if (wishes.memory) {
    change_memory();
  }
}

std::vector<Notice> Viewer::notices() const {
  std::vector<Notice> notices;
  const double age = Seconds(Clock::now() - told_).count();
  if (!notice_.text.empty() && (notice_.mood == Mood::Failure || age < kToldSeconds)) {
    notices.push_back(notice_);
  }
  if (opening_) {
    const auto [step, done] = opening_->progress();
    const bool preview = shown_ && shown_->preview() && shown_->source() == opening_file_;
    notices.push_back(
        {fmt::format("{} {}{}{}", preview ? "a preview; building" : "opening",
                     opening_file_.filename().string(), step.empty() ? "" : ": ", step),
         Mood::Working, done});
  }
  return notices;
}

void Viewer::tell(const std::string& text, Mood mood) {
  notice_ = {text, mood};
  told_ = Clock::now();
}

void Viewer::save_screenshot(const fs::path& file) {
  render::write_png(file, frame_->width(), frame_->height(), frame_->read_rgb());
  tell(fmt::format("saved {}", fs::absolute(file).string()));
}

void Viewer::log_frame() {
  const Clock::time_point now = Clock::now();
  const double ms = shown_at_ == Clock::time_point() ? 0 : Seconds(now - shown_at_).count() * 1000;
  shown_at_ = now;
  const std::clock_t cpu = std::clock();
  const double cpu_ms = 1000.0 * static_cast<double>(cpu - cpu_at_) / CLOCKS_PER_SEC;
  cpu_at_ = cpu;
  if (frames_at_rest_ <= kFramesToRest) {
    times_.add(static_cast<float>(ms));
  }
  if (log_) {
    const RefineStats& stats = shown_->refine_stats();
    log_->add({Seconds(now - kProgramStart).count(), ms, cpu_ms,
               shown_->preview() ? "preview" : "store", shown_->method(),
               name_of(controls_->mode()), controls_->pose(), above_ground_,
               window_.cursor().value_or(glm::dvec2(-1)), under_cursor_, frame_->width(),
               frame_->height(), stats.triangles, stats.late_blocks, stats.achieved_error_px});
  }
}

}  // namespace arete::app
