#pragma once

#include <chrono>
#include <string>
#include <string_view>

namespace arete::app {

enum class Talk { Normal, Quiet };

/// A one-line progress bar on stderr; nothing unless stderr is a terminal and talk is normal.
/// Redraws ten times a second at most, and leaves no line behind.
class ProgressBar {
 public:
  explicit ProgressBar(Talk talk);
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  void show(std::string_view step, double done);
  /// Takes it off the terminal, for a line that is to stay.
  void clear();

 private:
  bool terminal_;
  bool shown_ = false;
  std::string step_;
  std::chrono::steady_clock::time_point last_{};
};

}  // namespace arete::app
