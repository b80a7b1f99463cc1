// Simulated power cuts: builds are recorded, and of every moment states are drawn that the disk may
// be in; the real reader must find the old store, the new one or nothing.
#include <algorithm>
#include <chrono>

#include <fmt/format.h>

#include "arete/core/error.h"

#include "store/store_fixture.h"
#include "torture/crash_disk.h"
#include "torture/samples.h"
#include "torture/verbs.h"

namespace arete::torture {
namespace {

namespace fs = std::filesystem;

const std::string kStore = "t.arete";
const std::string kPart = kStore + ".part";
const std::string kRetired = kPart + "/retired";

// One recorded command over a known disk, and the stores that may be found afterwards.
struct Scenario {
  std::string name;
  DiskState before = {};
  std::vector<FileOp> ops = {};
  Files old_store = {}, new_store = {};  // old: empty when there was none
  std::function<void(const fs::path&)> command = {};
};

Files store_in(const DiskState& disk, const std::string& store = kStore) {
  Files files;
  for (const auto& [path, bytes] : disk.files)
    if (path.starts_with(store + "/")) files[path.substr(store.size() + 1)] = bytes;
  return files;
}

// A build and what the disk held before it; the recording must lead to what lies there now.
Scenario record_scenario(const std::string& name, const fs::path& folder,
                         const std::function<void(const fs::path&)>& command) {
  Scenario s{.name = name, .before = read_disk(folder), .command = command};
  s.old_store = store_in(s.before);
  if (s.old_store.empty()) s.old_store = store_in(s.before, kRetired);
  s.ops = record(folder, [&] { command(folder / kStore); });
  const DiskState after = read_disk(folder);
  const DiskState replayed = CrashDisk(s.before, s.ops).final_state();
  if (replayed.files != after.files || replayed.directories != after.directories)
    throw Error(ErrorCode::Io, "recorder: " + name + ": a change of the disk was not seen");
  s.new_store = store_in(after);
  return s;
}

// The operation that moves the old store aside or back; the number of operations when none does.
std::size_t move_of_old(const Scenario& s) {
  const auto moves = [](const FileOp& op) {
    return op.kind == FileOp::Kind::Rename && (op.path == kRetired || op.other == kRetired);
  };
  return static_cast<std::size_t>(std::ranges::find_if(s.ops, moves) - s.ops.begin());
}

// The next build after a replacement that was killed between its two renames.
Scenario record_return(const Scenario& replacement) {
  const store::TemporaryFolder folder;
  const fs::path root = fs::canonical(folder.path());
  const auto end =
      replacement.ops.begin() + static_cast<std::ptrdiff_t>(move_of_old(replacement)) + 1;
  write_disk(CrashDisk(replacement.before, {replacement.ops.begin(), end}).final_state(), root);
  return record_scenario("build --force, the old store retired", root,
                         [](const fs::path& output) { build_sample(output, 4); });
}

std::vector<Scenario> record_all() {
  const store::TemporaryFolder folder;
  const fs::path root = fs::canonical(folder.path());
  const auto build = [](std::uint32_t seed) {
    return [seed](const fs::path& output) { build_sample(output, seed); };
  };
  std::vector<Scenario> scenarios;
  scenarios.push_back(record_scenario("build", root, build(1)));
  scenarios.push_back(record_scenario("build --force", root, build(2)));
  scenarios.push_back(record_scenario("extend", root, extend_sample));
  scenarios.push_back(record_scenario("build --force, no exchange", root, [](const auto& output) {
    without_exchange([&] { build_sample(output, 3); });
  }));
  scenarios.push_back(record_return(scenarios.back()));
  return scenarios;
}

// Once the lock file has gone another builder may begin: nothing may be removed behind it but the
// empty directory.
bool removes_lock_last(const Scenario& s) {
  const auto removes = [&](std::size_t op, const std::string& path) {
    return s.ops[op].kind == FileOp::Kind::Remove && s.ops[op].path == path;
  };
  const std::size_t last = s.ops.size() - 1;
  for (std::size_t op = 0; op < last; ++op)
    if (removes(op, kPart + "/lock") && !removes(op + 1, kPart)) return false;
  return removes(last - 1, kPart + "/lock");
}

enum class Found { Nothing, Old, New, Refused, Wrong };

Found judge(const DiskState& disk, const Scenario& s) {
  if (!disk.directories.contains(kStore))  // the next build brings a retired one back
    return !s.old_store.empty() && store_in(disk, kRetired) == s.old_store ? Found::Old
                                                                           : Found::Nothing;
  const Files files = store_in(disk);
  try {
    open_in_memory(files)->check_all();
  } catch (const Error&) {
    return Found::Refused;
  }
  if (files == s.new_store) return Found::New;
  return files == s.old_store ? Found::Old : Found::Wrong;
}

struct Tally {
  long states = 0, nothing = 0, old = 0, fresh = 0, refused = 0, wrong = 0;
  long lost = 0;   // an acknowledged store, or the old one, is not there
  long fools = 0;  // would be taken for whole by a reader without hashes
  long faults() const { return refused + wrong + lost; }
  void add(const Tally& other) {
    states += other.states, nothing += other.nothing, old += other.old, fresh += other.fresh;
    refused += other.refused, wrong += other.wrong, lost += other.lost;
    fools += other.fools;
  }
};

// The control of the reader: one that looks at names and sizes, not at hashes.
bool fools_reader_of_sizes(const Files& files, const Scenario& s) {
  const auto same_file = [](const auto& a, const auto& b) {
    return a.first == b.first && a.second.size() == b.second.size();
  };
  const auto looks_like = [&](const Files& store) {
    return std::ranges::equal(files, store, same_file);
  };
  const bool is_whole = files == s.new_store || files == s.old_store;
  return !is_whole && (looks_like(s.new_store) || looks_like(s.old_store));
}

// How many operations are done: most often nearly all, where the store is published and
// acknowledged; in a third of the draws, where an old store moves aside or back, that and up to
// three more.
std::size_t draw_moment(const Scenario& s, std::mt19937_64& random) {
  const std::size_t ops = s.ops.size();
  if (const std::size_t move = move_of_old(s); move < ops && random() % 3 == 0)
    return std::min(move + 1 + random() % 4, ops);
  const double u = std::uniform_real_distribution(0.0, 1.0)(random);
  return ops - static_cast<std::size_t>(u * u * static_cast<double>(ops));
}

Tally draw(const Scenario& s, const CrashDisk& disk, int states, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  Tally tally;
  for (int i = 0; i < states; ++i) {
    const std::size_t done = draw_moment(s, random);
    const DiskState state = disk.crash(done, "", random);
    const Found found = judge(state, s);
    ++tally.states;
    tally.nothing += found == Found::Nothing ? 1 : 0;
    tally.old += found == Found::Old ? 1 : 0;
    tally.fresh += found == Found::New ? 1 : 0;
    tally.refused += found == Found::Refused ? 1 : 0;
    tally.wrong += found == Found::Wrong ? 1 : 0;
    const bool acknowledged = done == s.ops.size();
    const bool had_old = !s.old_store.empty();
    tally.lost +=
        (acknowledged && found != Found::New) || (had_old && found == Found::Nothing) ? 1 : 0;
    tally.fools += fools_reader_of_sizes(store_in(state), s) ? 1 : 0;
  }
  return tally;
}

void print(const std::string& what, const Tally& t) {
  fmt::print(
      "{:<52} {:>8} states: nothing {}, old {}, new {}; refused {}, wrong {}, lost {}, would fool "
      "a "
      "reader of sizes {}\n",
      what, t.states, t.nothing, t.old, t.fresh, t.refused, t.wrong, t.lost, t.fools);
}

std::set<std::size_t> syncs_of(const Scenario& s) {
  std::set<std::size_t> syncs;
  for (std::size_t op = 0; op < s.ops.size(); ++op)
    if (s.ops[op].kind == FileOp::Kind::Sync) syncs.insert(op);
  return syncs;
}

// Control: without any sync, stores must be found broken; and without any single one of those that
// the published store, or an old one that moves aside or back, rests on. (Those of the key keep a
// build from going on with a wrong one.)
int miss_controls(const Scenario& s, int states) {
  int missed = 0;
  const std::set<std::size_t> syncs = syncs_of(s);
  const Tally none = draw(s, CrashDisk(s.before, s.ops, syncs), states, 5);
  print("  control: no sync at all", none);
  missed += none.refused == 0 || none.lost == 0 || none.fools == 0 ? 1 : 0;
  for (const std::size_t op : syncs) {
    const std::string& path = s.ops[op].path;
    const bool publishes = path.empty() || path.starts_with(kPart + "/store");
    if (!publishes) continue;
    const Tally one = draw(s, CrashDisk(s.before, s.ops, {op}), states, op);
    // A segment that extend takes over is on disk already.
    const bool was_durable =
        s.name == "extend" && path.ends_with(".seg") && path.find("added") == std::string::npos;
    print("  control: no sync of " + (path.empty() ? "the folder" : path), one);
    missed += one.faults() == 0 && !was_durable ? 1 : 0;
  }
  return missed;
}

// The command is given again on a disk as the crash left it.
int wrong_resumes(const Scenario& s, int states) {
  std::mt19937_64 random(3);
  const CrashDisk disk(s.before, s.ops);
  int wrong = 0;
  for (int i = 0; i < states; ++i) {
    const store::TemporaryFolder folder;
    const DiskState state = disk.crash(random() % s.ops.size(), "", random);
    write_disk(state, folder.path());
    try {
      s.command(folder / kStore);
    } catch (const Error& error) {
      fmt::print("  {}\n", error.what());
    }
    const DiskState after = read_disk(folder.path());
    const bool whole = store_in(after) == s.new_store && after.directories.size() == 1;
    wrong += whole ? 0 : 1;
  }
  return wrong;
}

}  // namespace

int crashsim(const CrashOptions& options) {
  int faults = 0;
  Tally all;
  const auto start = std::chrono::steady_clock::now();
  const std::vector<Scenario> scenarios = record_all();
  for (const Scenario& s : scenarios) {
    const Tally tally =
        draw(s, CrashDisk(s.before, s.ops), options.states / static_cast<int>(scenarios.size()), 1);
    print(s.name, tally);
    faults += tally.faults() > 0 || !removes_lock_last(s) ? 1 : 0;
    all.add(tally);
  }
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  print("all", all);
  fmt::print("{:.0f} states/s\n", static_cast<double>(all.states) / seconds.count());
  for (const Scenario& s : scenarios) {
    fmt::print("{}:\n", s.name);
    faults += miss_controls(s, options.control_states);
    const int wrong = wrong_resumes(s, options.resumes);
    fmt::print("  {} commands given again after a crash: {} wrong\n", options.resumes, wrong);
    faults += wrong;
  }
  return faults;
}

}  // namespace arete::torture
