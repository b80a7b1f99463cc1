#pragma once

#include <atomic>
#include <exception>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>

#include "shown_terrain.h"

namespace arete::app {

/// Opens a store or a DEM on a thread of its own. A DEM that must be built first gives a preview of
/// about a thousand posts a side, then, when its store is built, the whole.
class BackgroundOpen {
 public:
  struct Progress {
    std::string step;
    double done = 0;  ///< 0..1
  };

  /// A store without this method is opened with the first that it holds.
  BackgroundOpen(TerrainFlags flags, std::string method);
  /// Cancels what is running and waits for it; a build leaves what it needs to go on.
  ~BackgroundOpen();
  BackgroundOpen(const BackgroundOpen&) = delete;
  BackgroundOpen& operator=(const BackgroundOpen&) = delete;

  Progress progress() const;
  /// What has become ready and was not taken; nothing while there is nothing new.
  std::optional<OpenedTerrain> take();
  /// True when no more will come. Then failure() says why, if it should have.
  bool finished() const { return finished_; }
  std::exception_ptr failure() const;

 private:
  void run();
  void offer(OpenedTerrain opened);
  bool tell(std::string_view step, double done);

  TerrainFlags flags_;
  std::string method_;
  std::atomic<bool> cancelled_ = false, finished_ = false;
  mutable std::mutex mutex_;  ///< guards the next three
  Progress progress_;
  std::optional<OpenedTerrain> ready_;
  std::exception_ptr failure_;
  std::jthread thread_;  ///< last: it uses all the others
};

}  // namespace arete::app
