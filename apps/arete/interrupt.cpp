#include "interrupt.h"

#include <csignal>

#include <fmt/format.h>

#include "arete/core/error.h"

namespace arete::app {
namespace {

volatile std::sig_atomic_t stop_wanted = 0;

extern "C" void note_interrupt(int) {
  stop_wanted = 1;
}

}  // namespace

void catch_interrupts() {
  struct sigaction action {};
  action.sa_handler = note_interrupt;
  action.sa_flags = static_cast<int>(SA_RESETHAND);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

void turn_size_limit_into_error() {
  std::signal(SIGXFSZ, SIG_IGN);
}

bool interrupted() {
  return stop_wanted != 0;
}

void stop_if_interrupted(std::string_view file) {
  if (interrupted()) {
    throw Error(ErrorCode::Cancelled,
                fmt::format("{}: interrupted, nothing was written: run it again", file));
  }
}

}  // namespace arete::app
