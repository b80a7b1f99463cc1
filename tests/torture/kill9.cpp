// kill -9 of the real program at random moments of a build, with readers opening all the while.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <mutex>
#include <shared_mutex>
#include <thread>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/inotify.h>
#include <sys/wait.h>
#include <unistd.h>

#include "arete/core/error.h"
#include "arete/store/terrain.h"

#include "store/store_fixture.h"
#include "torture/recorder.h"
#include "torture/verbs.h"

namespace arete::torture {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;

pid_t start(const std::vector<std::string>& command) {
  std::vector<char*> arguments;
  for (const std::string& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  const pid_t child = ::fork();
  if (child != 0) return child;
  const int nothing = ::open("/dev/null", O_WRONLY);
  ::dup2(nothing, STDOUT_FILENO);
  ::execv(arguments[0], arguments.data());
  ::_exit(127);
}

int wait_for(pid_t child) {
  int status = 0;
  ::waitpid(child, &status, 0);
  return status;
}

void run(const std::vector<std::string>& command) {
  if (wait_for(start(command)) != 0)
    throw Error(ErrorCode::Io, "kill9: failed: " + command[0] + " " + command[1]);
}

// What readers met. They stand still while the driver itself removes the store.
struct Watch {
  fs::path store;
  std::vector<std::string> known_ids;
  std::shared_mutex reset;
  std::mutex turnstile;  // lets the driver in although readers never pause
  std::atomic<bool> may_be_absent{false};
  std::atomic<long> opens{0}, absent{0}, torn{0};

  void open_once() {
    { const std::scoped_lock turn(turnstile); }
    const std::shared_lock lock(reset);
    const bool absence_is_right = may_be_absent;
    store::OpenOptions options;
    options.prefetch = false;
    try {
      const auto terrain = store::Terrain::open(store, options);
      terrain->check_all();
      const bool known = std::ranges::count(known_ids, terrain->manifest().id) == 1;
      ++(known ? opens : torn);
    } catch (const Error& error) {
      const bool nothing = error.code() == ErrorCode::NotFound && absence_is_right;
      ++(nothing ? absent : torn);
      if (!nothing) fmt::print("  reader: {}\n", error.what());
    }
  }
};

// Names of finished work that a killed build has left, and whether any of it is made again.
class FinishedWork {
 public:
  explicit FinishedWork(const fs::path& part) : events_(::inotify_init1(IN_NONBLOCK)) {
    for (const char* folder : {"units", "store"}) {
      std::error_code none;
      for (const auto& entry : fs::directory_iterator(part / folder, none)) {
        const std::string name = entry.path().filename().string();
        in_work_ += name.ends_with(".tmp") ? 1 : 0;
        if (name.ends_with(".unit") || name.ends_with(".seg")) finished_.push_back(name);
      }
      // A resumed build moves its store into place; one begun anew deletes it, watch and all.
      const bool is_store = std::string_view(folder) == "store";
      const int watch = ::inotify_add_watch(events_, (part / folder).c_str(),
                                            IN_MOVED_TO | (is_store ? IN_DELETE_SELF : 0U));
      if (watch < 0 && fs::exists(part / folder))
        throw Error(ErrorCode::Io, "kill9: inotify cannot watch " + (part / folder).string());
    }
  }
  ~FinishedWork() { ::close(events_); }
  FinishedWork(const FinishedWork&) = delete;
  FinishedWork& operator=(const FinishedWork&) = delete;

  std::size_t finished() const { return finished_.size(); }
  int in_work() const { return in_work_; }
  long made_again() const {
    alignas(inotify_event) std::array<char, 65536> buffer;
    long again = 0;
    for (ssize_t n = 0; (n = ::read(events_, buffer.data(), buffer.size())) > 0;)
      for (ssize_t at = 0; at < n;) {
        const auto* event = reinterpret_cast<const inotify_event*>(buffer.data() + at);
        if ((event->mask & IN_DELETE_SELF) != 0) again += static_cast<long>(finished_.size());
        again += event->len > 0 && std::ranges::count(finished_, event->name) > 0 ? 1 : 0;
        at += static_cast<ssize_t>(sizeof(inotify_event) + event->len);
      }
    return again;
  }

 private:
  int events_;
  std::vector<std::string> finished_;
  int in_work_ = 0;
};

class Killer {
 public:
  explicit Killer(const KillOptions& options) : options_(options), random_(options.points) {
    for (int i = 0; i < 2; ++i) {
      const std::string dem = (folder_ / fmt::format("{}.tif", i)).string();
      run({program(), "synth", "-o", dem, "--size", std::to_string(options.size), "--seed",
           std::to_string(i + 1), "--quiet"});
      const fs::path reference = folder_ / fmt::format("{}.arete", i);
      run(build(i, reference));
      stores_[i] = store::read_all_files(reference);
      watch_.known_ids.push_back(store::Terrain::open(reference)->manifest().id);
    }
    watch_.store = folder_ / "t.arete";
    run(build(0, watch_.store));
  }

  int kill_all() {
    std::vector<std::jthread> readers;
    for (int r = 0; r < options_.readers; ++r)
      readers.emplace_back([this](const std::stop_token& stop) {
        while (!stop.stop_requested()) watch_.open_once();
      });
    measure_one_build();
    for (int i = 0; i < options_.points; ++i) kill_once(i);
    readers.clear();
    fmt::print(
        "{} kills over {:.2f} s of a build, {} of them at work: {} left the old store, {} "
        "nothing, {} the new one, {} something else\n",
        options_.points, seconds_, midway_, old_, nothing_, new_, wrong_);
    fmt::print(
        "resumed: {} with other bytes, {} with something left beside; {} finished pieces "
        "found, {} made again; at most {} in work at a kill; {} kills in the last step\n",
        resumed_wrong_, leftovers_, finished_, made_again_, in_work_max_, last_step_);
    fmt::print("readers: {} opened and verified, {} found nothing where nothing was, {} torn\n",
               watch_.opens.load(), watch_.absent.load(), watch_.torn.load());
    // Control: the kills must have met the build at work, in more than its beginning.
    // And the readers must have read.
    const bool bites = midway_ > options_.points / 4 && finished_ > 0 &&
                       (options_.readers == 0 || watch_.opens > options_.points);
    return wrong_ + resumed_wrong_ + leftovers_ + static_cast<int>(made_again_ + watch_.torn) +
           (bites ? 0 : 1);
  }

 private:
  std::string program() const { return options_.arete.string(); }
  std::vector<std::string> build(int source, const fs::path& store) const {
    return {program(), "build",        (folder_ / fmt::format("{}.tif", source)).string(),
            "-o",      store.string(), "--force",
            "--quiet", "--threads",    "2"};
  }
  fs::path part() const { return folder_ / "t.arete.part"; }

  // With the readers at work, as at the kills.
  void measure_one_build() {
    const auto begin = Clock::now();
    run(build(1 - current_, watch_.store));
    seconds_ = Seconds(Clock::now() - begin).count();
    current_ = 1 - current_;
  }

  // Kills a build of the other source (every fourth over nothing), looks, and lets it finish.
  void kill_once(int i) {
    const int source = 1 - current_;
    const bool over_nothing = i % 4 == 3;
    if (over_nothing) {
      const std::scoped_lock turn(watch_.turnstile);
      const std::unique_lock lock(watch_.reset);
      fs::remove_all(watch_.store);
      watch_.may_be_absent = true;
    }
    const double delay = std::uniform_real_distribution(0.0, seconds_)(random_);
    const pid_t child = start(build(source, watch_.store));
    std::this_thread::sleep_for(Seconds(delay));
    ::kill(child, SIGKILL);
    midway_ += WIFSIGNALED(wait_for(child)) ? 1 : 0;
    look(source, over_nothing);
    const auto begin = Clock::now();
    resume(source);
    // Other work on the machine stretches a build: the kills go with it.
    seconds_ += (delay + Seconds(Clock::now() - begin).count() - seconds_) / 4;
    watch_.may_be_absent = false;
    current_ = source;
  }

  void look(int source, bool over_nothing) {
    if (!fs::exists(watch_.store)) {
      ++(over_nothing ? nothing_ : wrong_);
      return;
    }
    const Files found = store::read_all_files(watch_.store);
    ++(found == stores_[source]                      ? new_
       : found == stores_[current_] && !over_nothing ? old_
                                                     : wrong_);
    run({program(), "info", watch_.store.string(), "--check"});
  }

  void resume(int source) {
    const bool last_step = fs::exists(part() / "store") && !fs::exists(part() / "key");
    const FinishedWork work(part());
    run(build(source, watch_.store));
    last_step_ += last_step ? 1 : 0;
    finished_ += last_step ? 0 : static_cast<long>(work.finished());
    made_again_ += last_step ? 0 : work.made_again();
    in_work_max_ = std::max(in_work_max_, work.in_work());
    resumed_wrong_ += store::read_all_files(watch_.store) == stores_[source] ? 0 : 1;
    leftovers_ += fs::exists(part()) ? 1 : 0;
  }

  KillOptions options_;
  std::mt19937 random_;
  store::TemporaryFolder folder_;
  std::array<Files, 2> stores_;
  Watch watch_;
  double seconds_ = 0;  // of an undisturbed build
  int current_ = 0;     // the source of the store that stands
  int midway_ = 0, old_ = 0, nothing_ = 0, new_ = 0, wrong_ = 0;
  int resumed_wrong_ = 0, leftovers_ = 0, in_work_max_ = 0, last_step_ = 0;
  long finished_ = 0, made_again_ = 0;
};

}  // namespace

int kill9(const KillOptions& options) {
  return Killer(options).kill_all();
}

}  // namespace arete::torture
