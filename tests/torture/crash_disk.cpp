#include "torture/crash_disk.h"

#include <algorithm>
#include <fstream>
#include <iterator>

namespace arete::torture {

namespace fs = std::filesystem;
using Kind = FileOp::Kind;

// How one crash treats what no sync has covered.
struct CrashDisk::Lot {
  std::mt19937_64& random;
  unsigned entry_percent, sector_percent;  // kept
  std::size_t journal_end;                 // in order: entries changed before it are kept
  bool in_order;
  char lost;  // what a lost sector reads as

  Lot(std::mt19937_64& source, std::size_t ops_done) : random(source) {
    constexpr unsigned kShares[] = {0, 10, 50, 90, 100};
    entry_percent = kShares[random() % 5];
    sector_percent = kShares[random() % 5];
    journal_end = random() % (ops_done + 1);
    in_order = random() % 2 == 0;
    lost = random() % 2 == 0 ? '\0' : '\xa5';
  }
  bool keeps(unsigned percent) { return random() % 100 < percent; }
  bool keeps_entry(std::size_t op) { return in_order ? op < journal_end : keeps(entry_percent); }
};

CrashDisk::CrashDisk(const DiskState& before, const std::vector<FileOp>& ops,
                     const std::set<std::size_t>& ignored)
    : op_count_(ops.size()) {
  add_inode(true);
  for (const std::string& path : before.directories) live_[place_of(path)] = add_inode(true);
  for (const auto& [path, bytes] : before.files) {
    const int inode = add_inode(false);
    inodes_[static_cast<std::size_t>(inode)].bytes = bytes;
    live_[place_of(path)] = inode;
  }
  before_ = live_;
  for (std::size_t op = 0; op < ops.size(); ++op)
    if (!ignored.contains(op)) apply(op, ops[op]);
}

int CrashDisk::add_inode(bool is_directory) {
  inodes_.push_back({is_directory});
  return static_cast<int>(inodes_.size()) - 1;
}

int CrashDisk::find_in(const Entries& entries, const std::string& path) {
  int inode = 0;
  for (const fs::path& name : fs::path(path)) {
    const auto found = entries.find({inode, name.string()});
    if (found == entries.end()) return kNone;
    inode = found->second;
  }
  return inode;
}

int CrashDisk::find(const std::string& path) const {
  return find_in(live_, path);
}

CrashDisk::Place CrashDisk::place_of(const std::string& path) const {
  const fs::path whole(path);
  return {find(whole.parent_path().string()), whole.filename().string()};
}

void CrashDisk::set_entries(std::size_t op, std::vector<std::pair<Place, int>> sets) {
  for (const auto& [place, inode] : sets) {
    if (inode == kNone)
      live_.erase(place);
    else
      live_[place] = inode;
  }
  entry_changes_.push_back({op, std::move(sets)});
}

void CrashDisk::apply(std::size_t op, const FileOp& what) {
  const int inode = find(what.path);
  const Place place = place_of(what.path);
  switch (what.kind) {
    case Kind::Create:
      return set_entries(op, {{place, add_inode(false)}});
    case Kind::MakeDirectory:
      return set_entries(op, {{place, add_inode(true)}});
    case Kind::Remove:
      return set_entries(op, {{place, kNone}});
    case Kind::Rename:
      return set_entries(op, {{place, kNone}, {place_of(what.other), inode}});
    case Kind::Exchange:
      return set_entries(op, {{place, find(what.other)}, {place_of(what.other), inode}});
    case Kind::Link:
      return set_entries(op, {{place_of(what.other), inode}});
    case Kind::Write:
    case Kind::Allocate:
      return inodes_.at(static_cast<std::size_t>(inode))
          .changes.push_back({op, what.offset, what.bytes, what.offset + what.bytes.size()});
    case Kind::Sync:
      return sync(op, inode);
  }
}

void CrashDisk::sync(std::size_t op, int inode) {
  for (DataChange& change : inodes_.at(static_cast<std::size_t>(inode)).changes)
    change.durable = std::min(change.durable, op);
  for (EntryChange& change : entry_changes_)
    for (const auto& set : change.sets)
      if (set.first.first == inode) change.durable = std::min(change.durable, op);
}

CrashDisk::Entries CrashDisk::crashed_entries(std::size_t ops_done, Lot& lot) const {
  Entries entries = before_;
  for (const EntryChange& change : entry_changes_) {
    if (change.op >= ops_done) break;
    if (change.durable >= ops_done && !lot.keeps_entry(change.op)) continue;
    for (const auto& [place, inode] : change.sets) {
      if (inode == kNone)
        entries.erase(place);
      else
        entries[place] = inode;
    }
  }
  return entries;
}

Bytes CrashDisk::crashed_bytes(const Inode& inode, std::size_t ops_done, Lot& lot) const {
  constexpr std::size_t kSector = 512;
  std::vector<std::uint64_t> sizes{inode.bytes.size()};  // those that the file may have
  for (const DataChange& change : inode.changes) {
    if (change.op >= ops_done) break;
    const std::uint64_t size = std::max(sizes.back(), change.size);
    if (change.durable < ops_done) sizes.clear();
    sizes.push_back(size);
  }
  Bytes bytes = inode.bytes;
  bytes.resize(sizes[lot.random() % sizes.size()], sizes.size() > 1 ? lot.lost : '\0');
  for (const DataChange& change : inode.changes) {
    if (change.op >= ops_done) break;
    const bool durable = change.durable < ops_done;
    for (std::size_t at = 0; at < change.bytes.size(); at += kSector) {
      const std::size_t to = change.offset + at;
      if (to >= bytes.size()) break;
      const std::size_t n = std::min({kSector, change.bytes.size() - at, bytes.size() - to});
      if (durable || lot.keeps(lot.sector_percent))
        std::copy_n(change.bytes.begin() + static_cast<std::ptrdiff_t>(at), n,
                    bytes.begin() + static_cast<std::ptrdiff_t>(to));
    }
  }
  return bytes;
}

void CrashDisk::collect(const Entries& entries, int directory, const std::string& path,
                        const std::function<Bytes(const Inode&)>& bytes_of, DiskState& out) const {
  for (auto it = entries.lower_bound({directory, ""});
       it != entries.end() && it->first.first == directory; ++it) {
    const std::string name = path.empty() ? it->first.second : path + "/" + it->first.second;
    const Inode& inode = inodes_[static_cast<std::size_t>(it->second)];
    if (!inode.is_directory) {
      out.files[name] = bytes_of(inode);
      continue;
    }
    if (!out.directories.insert(name).second) continue;
    collect(entries, it->second, name, bytes_of, out);
  }
}

DiskState CrashDisk::crash(std::size_t ops_done, const std::string& folder,
                           std::mt19937_64& random) const {
  Lot lot(random, ops_done);
  const Entries entries = crashed_entries(ops_done, lot);
  const int top = find_in(entries, folder);
  DiskState state;
  if (top == kNone) return state;
  if (!folder.empty()) state.directories.insert(folder);
  collect(
      entries, top, folder, [&](const Inode& inode) { return crashed_bytes(inode, ops_done, lot); },
      state);
  return state;
}

DiskState CrashDisk::final_state() const {
  DiskState state;
  const auto all_of = [&](const Inode& inode) {
    Bytes bytes = inode.bytes;
    for (const DataChange& change : inode.changes) {
      bytes.resize(std::max<std::size_t>(bytes.size(), change.size));
      std::ranges::copy(change.bytes, bytes.begin() + static_cast<std::ptrdiff_t>(change.offset));
    }
    return bytes;
  };
  collect(live_, 0, "", all_of, state);
  return state;
}

DiskState read_disk(const fs::path& folder) {
  DiskState state;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const std::string name = entry.path().lexically_relative(folder).string();
    if (entry.is_directory()) {
      state.directories.insert(name);
      continue;
    }
    std::ifstream in(entry.path(), std::ios::binary);
    state.files[name] = {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  }
  return state;
}

void write_disk(const DiskState& state, const fs::path& folder) {
  for (const std::string& directory : state.directories) fs::create_directories(folder / directory);
  for (const auto& [name, bytes] : state.files)
    std::ofstream(folder / name, std::ios::binary)
        .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

}  // namespace arete::torture
