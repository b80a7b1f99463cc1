#pragma once

#include <cstddef>
#include <functional>
#include <limits>
#include <map>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "torture/recorder.h"

namespace arete::torture {

/// What a disk may hold after a crash: files and directories by path.
struct DiskState {
  Files files;
  std::set<std::string> directories;
};

/// The disk states that a recording may leave behind when the power goes at any of its operations.
///
/// Durable is what a sync of that very file (its bytes and size) or of that very directory (its
/// entries) has covered. All else is drawn by lot: entries as a journal that breaks off, or each
/// for itself and so out of order; bytes by sectors of 512, lost ones reading as zeros or as what
/// lay there before; sizes anywhere between the last durable and the largest. A rename is one
/// change, as every journalling file system makes it.
class CrashDisk {
 public:
  /// `before` is durable. Operations in `ignored` never happened: a writer without that sync.
  CrashDisk(const DiskState& before, const std::vector<FileOp>& ops,
            const std::set<std::size_t>& ignored = {});
  /// A state after the first `ops_done` operations, of what lies below `folder`.
  DiskState crash(std::size_t ops_done, const std::string& folder, std::mt19937_64& random) const;
  /// The state without a crash.
  DiskState final_state() const;

 private:
  static constexpr int kNone = -1;
  static constexpr std::size_t kNever = std::numeric_limits<std::size_t>::max();
  using Place = std::pair<int, std::string>;  // directory, name
  using Entries = std::map<Place, int>;       // the inode at a place

  struct EntryChange {
    std::size_t op;
    std::vector<std::pair<Place, int>> sets;  // kNone removes
    std::size_t durable = kNever;             // the operation from which on it is
  };
  struct DataChange {
    std::size_t op;
    std::uint64_t offset;
    Bytes bytes;         // empty: only the size changes
    std::uint64_t size;  // the file is at least this long afterwards
    std::size_t durable = kNever;
  };
  struct Inode {
    bool is_directory = false;
    Bytes bytes = {};  // before the recording
    std::vector<DataChange> changes = {};
  };
  struct Lot;

  int add_inode(bool is_directory);
  Place place_of(const std::string& path) const;
  int find(const std::string& path) const;
  void set_entries(std::size_t op, std::vector<std::pair<Place, int>> sets);
  void apply(std::size_t op, const FileOp& what);
  void sync(std::size_t op, int inode);
  Entries crashed_entries(std::size_t ops_done, Lot& lot) const;
  Bytes crashed_bytes(const Inode& inode, std::size_t ops_done, Lot& lot) const;
  void collect(const Entries& entries, int directory, const std::string& path,
               const std::function<Bytes(const Inode&)>& bytes_of, DiskState& out) const;
  static int find_in(const Entries& entries, const std::string& path);

  std::vector<Inode> inodes_;  // 0 is the root
  Entries before_, live_;
  std::vector<EntryChange> entry_changes_;
  std::size_t op_count_;
};

/// The folder as it lies on the real disk.
DiskState read_disk(const std::filesystem::path& folder);
/// Puts the state into an empty folder.
void write_disk(const DiskState& state, const std::filesystem::path& folder);

}  // namespace arete::torture
