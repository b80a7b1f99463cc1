#include "progress.h"

#include <algorithm>
#include <cstdio>

#include <fmt/format.h>
#include <unistd.h>

namespace arete::app {

ProgressBar::ProgressBar(Talk talk) : terminal_(talk == Talk::Normal && isatty(STDERR_FILENO)) {}

ProgressBar::~ProgressBar() {
  clear();
}

void ProgressBar::clear() {
  if (shown_) {
    fmt::print(stderr, "\r\033[K");
    std::fflush(stderr);
  }
  shown_ = false;
}

void ProgressBar::show(std::string_view step, double done) {
  constexpr int kWidth = 30;
  const auto now = std::chrono::steady_clock::now();
  if (!terminal_ || (step == step_ && now - last_ < std::chrono::milliseconds(100))) {
    return;
  }
  last_ = now;
  step_ = step;
  shown_ = true;
  const double share = std::clamp(done, 0.0, 1.0);
  fmt::print(stderr, "\r\033[K{:>3.0f}% [{:<{}}] {}", 100 * share,
             std::string(static_cast<std::size_t>(share * kWidth), '='), kWidth, step);
  std::fflush(stderr);
}

}  // namespace arete::app
