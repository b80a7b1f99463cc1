#include <array>
#include <cassert>
#include <cerrno>
#include <csignal>
#include <string>
#include <system_error>
#include <vector>

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <pthread.h>
#include <sys/wait.h>
#include <unistd.h>

#include "arete/core/error.h"
#include "arete/render/picture.h"

namespace arete::render {
namespace {

// Blocks SIGPIPE on this thread while a pipe is written, and swallows the one it may have caused:
// the host program's own handlers are left alone.
class PipeSignalGuard {
 public:
  PipeSignalGuard() {
    sigemptyset(&pipe_);
    sigaddset(&pipe_, SIGPIPE);
    sigset_t pending;
    sigpending(&pending);
    was_pending_ = sigismember(&pending, SIGPIPE) == 1;
    pthread_sigmask(SIG_BLOCK, &pipe_, &before_);
  }
  ~PipeSignalGuard() {
    const timespec now{0, 0};
    if (!was_pending_) {
      while (sigtimedwait(&pipe_, nullptr, &now) == -1 && errno == EINTR) {
      }
    }
    pthread_sigmask(SIG_SETMASK, &before_, nullptr);
  }
  PipeSignalGuard(const PipeSignalGuard&) = delete;
  PipeSignalGuard& operator=(const PipeSignalGuard&) = delete;

 private:
  sigset_t pipe_{}, before_{};
  bool was_pending_ = false;
};

struct Pipe {
  int read_end = -1, write_end = -1;
};

Pipe make_pipe() {
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) {
    throw Error(ErrorCode::Io,
                fmt::format("ffmpeg: no pipe: {}", std::generic_category().message(errno)));
  }
  return {ends[0], ends[1]};
}

// A file name that starts with '-' or holds ':' would be read as an option or a protocol.
std::vector<std::string> ffmpeg_arguments(const std::filesystem::path& file, int width, int height,
                                          int frames_per_second) {
  return {"ffmpeg",
          "-nostdin",
          "-loglevel",
          "error",
          "-y",
          "-f",
          "rawvideo",
          "-pix_fmt",
          "rgb24",
          "-video_size",
          fmt::format("{}x{}", width, height),
          "-framerate",
          fmt::format("{}", frames_per_second),
          "-i",
          "pipe:0",
          "-vf",
          "pad=ceil(iw/2)*2:ceil(ih/2)*2",
          "-c:v",
          "libx264",
          "-crf",
          "18",
          "-pix_fmt",
          "yuv420p",
          "-movflags",
          "+faststart",
          "-f",
          "mp4",
          "file:" + file.string()};
}

// The child's side of fork: only async-signal-safe calls. exec failing is told through `failure`.
[[noreturn]] void run_child(int input, int failure, char* const* arguments) {
  signal(SIGPIPE, SIG_DFL);
  const int nowhere = open("/dev/null", O_WRONLY);
  if (nowhere >= 0) {
    dup2(nowhere, STDOUT_FILENO);
    dup2(nowhere, STDERR_FILENO);
  }
  dup2(input, STDIN_FILENO);
  execvp(arguments[0], arguments);
  const int why = errno;
  const ssize_t told = write(failure, &why, sizeof why);
  _exit(told == sizeof why ? 127 : 126);
}

// errno of a failed exec, 0 when ffmpeg runs: the pipe closes itself on exec.
int exec_failure(int read_end) {
  int why = 0;
  ssize_t got = 0;
  do {
    got = read(read_end, &why, sizeof why);
  } while (got == -1 && errno == EINTR);
  return got == sizeof why ? why : 0;
}

}  // namespace

struct VideoWriter::Impl {
  std::filesystem::path file;
  std::size_t frame_bytes = 0;
  int input = -1;  // ffmpeg's standard input
  pid_t child = -1;
  bool finished = false;

  ~Impl() {
    const bool running = child > 0;
    wait_for_child();
    if (finished || !running) return;
    remove_file();
  }

  void start(const std::vector<std::string>& words) {
    std::vector<char*> arguments;
    arguments.reserve(words.size() + 1);
    for (const std::string& w : words) arguments.push_back(const_cast<char*>(w.c_str()));
    arguments.push_back(nullptr);
    const Pipe frames = make_pipe();
    const Pipe failure = make_pipe();
    child = fork();
    if (child == 0) run_child(frames.read_end, failure.write_end, arguments.data());
    close(frames.read_end);
    close(failure.write_end);
    input = frames.write_end;
    const int why = child < 0 ? errno : exec_failure(failure.read_end);
    close(failure.read_end);
    if (why == 0) return;
    wait_for_child();
    throw Error(ErrorCode::Unsupported,
                fmt::format("ffmpeg: cannot be started: {}: install the package ffmpeg",
                            std::generic_category().message(why)));
  }

  // Exit status of ffmpeg, -1 when it did not end by itself.
  int wait_for_child() {
    if (input >= 0) close(input);
    input = -1;
    if (child <= 0) return -1;
    int status = 0;
    while (waitpid(child, &status, 0) == -1 && errno == EINTR) {
    }
    child = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

  void remove_file() const {
    std::error_code ignored;
    std::filesystem::remove(file, ignored);
  }

  [[noreturn]] void fail() {
    const int status = wait_for_child();
    remove_file();
    throw Error(ErrorCode::Io,
                fmt::format("{}: ffmpeg failed (status {}): check the folder, the free space and "
                            "that ffmpeg has libx264",
                            file.string(), status));
  }
};

VideoWriter::VideoWriter(const std::filesystem::path& file, int width, int height,
                         int frames_per_second)
    : impl_(std::make_unique<Impl>()) {
  impl_->file = file;
  impl_->frame_bytes = static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 3;
  impl_->start(ffmpeg_arguments(file, width, height, frames_per_second));
}

VideoWriter::~VideoWriter() = default;

void VideoWriter::add(std::span<const std::uint8_t> rgb) {
  assert(rgb.size() == impl_->frame_bytes && impl_->input >= 0);
  const PipeSignalGuard guard;
  while (!rgb.empty()) {
    const ssize_t written = write(impl_->input, rgb.data(), rgb.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) impl_->fail();
    rgb = rgb.subspan(static_cast<std::size_t>(written));
  }
}

void VideoWriter::finish() {
  if (impl_->wait_for_child() != 0) impl_->fail();
  impl_->finished = true;
}

}  // namespace arete::render
