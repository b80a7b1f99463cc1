// Flipped bits, shortened files, swapped pages: the reader must notice or read the same.
#include <atomic>
#include <chrono>
#include <filesystem>
#include <mutex>

#include <fmt/format.h>

#include "arete/core/error.h"
#include "arete/core/parallel.h"
#include "arete/store/format.h"
#include "arete/store/output_file.h"
#include "arete/store/segment_reader.h"
#include "arete/store/terrain.h"

#include "store/memory_file.h"
#include "store/store_fixture.h"
#include "torture/samples.h"
#include "torture/verbs.h"

namespace arete::torture {
namespace {

namespace fs = std::filesystem;
using store::kPageBytes;

struct Tally {
  std::atomic<long> refused{0}, detected{0}, harmless{0}, silent{0};
  long faults() const { return silent; }
  void add(Harm harm) {
    harmless += harm == Harm::None ? 1 : 0;
    detected += harm == Harm::Detected ? 1 : 0;
    silent += harm == Harm::Silent ? 1 : 0;
  }
  void print(const std::string& what) const {
    fmt::print(
        "{:<34} {:>9}: {:>9} refused at open {:>9} met when read {:>6} harmless {:>6} silent\n",
        what, refused + detected + harmless + silent, refused.load(), detected.load(),
        harmless.load(), silent.load());
  }
};

enum class Depth { OneFile, Whole };

// Opens the damaged files and reads what the damaged one holds, or everything.
void examine(const Files& files, const std::string& damaged, const Content& intact, Depth depth,
             Tally& tally) {
  try {
    const auto terrain = open_in_memory(files);
    if (depth == Depth::Whole || damaged == "manifest.json")
      return tally.add(compare(read_everything(*terrain), intact, *terrain));
    const std::string segment = fs::path(damaged).stem().string();
    const Content part = read_segment(*terrain, segment);
    Content wanted;
    for (const auto& [name, hash] : intact)
      if (name.starts_with(segment + " ") && name.find(" texels 0") == std::string::npos)
        wanted.emplace(name, hash);
    tally.add(compare(part, wanted, *terrain));
  } catch (const Error&) {
    ++tally.refused;
  }
}

Content intact_content(const Files& files) {
  return read_everything(*open_in_memory(files));
}

void flip(Bytes& bytes, std::size_t bit) {
  bytes[bit / 8] = static_cast<char>(bytes[bit / 8] ^ (1 << (bit % 8)));
}

void flip_all(const Files& files, const std::string& name, const FlipOptions& options,
              Tally& tally) {
  const Content intact = intact_content(files);
  const auto stride = static_cast<std::size_t>(options.stride);
  const std::size_t bits = files.at(name).size() * 8;
  constexpr std::size_t kBitsEach = kPageBytes * 8;
  const auto pieces = static_cast<int>((bits + kBitsEach - 1) / kBitsEach);
  parallel_for(options.threads, pieces, [&](int piece) {
    Files mine = files;
    Bytes& bytes = mine.at(name);
    const std::size_t begin = static_cast<std::size_t>(piece) * kBitsEach;
    const std::size_t first = (begin + stride - 1) / stride;
    for (std::size_t i = first; i * stride < std::min(begin + kBitsEach, bits); ++i) {
      const bool whole = i % static_cast<std::size_t>(options.whole) == 0;
      flip(bytes, i * stride);
      examine(mine, name, intact, whole ? Depth::Whole : Depth::OneFile, tally);
      flip(bytes, i * stride);
    }
  });
}

// Control: flips that come through a reader that looks at no hash of page or block.
long silent_without_hashes(const Files& files, std::size_t samples) {
  long silent = 0;
  for (const auto& [name, intact] : files) {
    if (!name.ends_with(".seg")) continue;
    const store::SegmentReader good(std::make_unique<store::MemoryFile>(intact), name);
    for (std::size_t i = 0; i < samples; ++i) {
      Bytes bytes = intact;
      flip(bytes, (kPageBytes + i * (bytes.size() / 2 - kPageBytes) / samples) * 8 + i % 8);
      std::vector<std::byte> got;
      std::vector<std::byte> wanted;
      try {
        const store::SegmentReader weak(std::make_unique<store::MemoryFile>(bytes), name,
                                        store::Verify::Nothing);
        for (const std::uint64_t key : good.keys())
          silent += good.read(key, wanted) > 0 && weak.read(key, got) > 0 && got != wanted ? 1 : 0;
      } catch (const Error&) {
        continue;
      }
    }
  }
  return silent;
}

void swap_pages(const Files& files, Tally& tally) {
  const Content intact = intact_content(files);
  for (const auto& [name, bytes] : files) {
    if (!name.ends_with(".seg")) continue;
    Files damaged = files;
    const std::size_t pages = bytes.size() / kPageBytes;
    const auto page = [&](std::size_t i) {
      return damaged.at(name).begin() + static_cast<std::ptrdiff_t>(i * kPageBytes);
    };
    for (std::size_t a = 0; a < pages; ++a)
      for (std::size_t b = 0; b < a; ++b) {
        std::swap_ranges(page(a), page(a + 1), page(b));
        if (damaged.at(name) != bytes) examine(damaged, name, intact, Depth::OneFile, tally);
        std::swap_ranges(page(a), page(a + 1), page(b));
      }
  }
}

// Every shorter file in steps of a sector; a shorter one that opens is silent harm.
void shorten(const Files& files, Tally& tally) {
  const Content intact = intact_content(files);
  for (const auto& [name, bytes] : files) {
    const std::size_t step = name.ends_with(".json") ? 1 : 512;
    for (std::size_t size = 0; size < bytes.size(); size += step) {
      Files damaged = files;
      damaged.at(name).resize(size);
      examine(damaged, name, intact, Depth::Whole, tally);
    }
  }
}

void write_files(const Files& files, const fs::path& folder) {
  fs::remove_all(folder);
  fs::create_directories(folder);
  for (const auto& [name, bytes] : files)
    store::write_file_durably(folder / name, std::as_bytes(std::span(bytes)));
}

// The same while a reader has the real files open: nothing may be fetched that is not as written.
void shorten_under_reader(const Files& files, Tally& tally) {
  const store::TemporaryFolder folder;
  const fs::path path = folder / "t.arete";
  const Content intact = intact_content(files);
  for (const auto& [name, bytes] : files) {
    if (!name.ends_with(".seg")) continue;
    for (std::size_t size = 0; size < bytes.size(); size += 512) {
      if (size % kPageBytes != 0 && size % (5 * 512) != 0) continue;
      write_files(files, path);
      store::OpenOptions options;
      options.prefetch = false;
      const auto terrain = store::Terrain::open(path, options);
      fs::resize_file(path / name, size);
      tally.add(compare(read_everything(*terrain), intact, *terrain));
    }
  }
}

}  // namespace

int bitflip(const FlipOptions& options) {
  const Files files = sample_store(1);
  const auto start = std::chrono::steady_clock::now();
  long faults = 0;
  for (const auto& file : files) {
    Tally tally;
    flip_all(files, file.first, options, tally);
    tally.print("bits of " + file.first);
    faults += tally.faults();
  }
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  const long control = silent_without_hashes(files, 300);
  fmt::print("control: without page hashes {} flips read wrong in silence; {:.1f} s\n", control,
             seconds.count());
  return static_cast<int>(faults) + (control == 0 ? 1 : 0);
}

int trunc() {
  const Files files = sample_store(1);
  Tally shorter;
  shorten(files, shorter);
  shorter.print("shortened, each 512 bytes");
  Tally live;
  shorten_under_reader(files, live);
  live.print("shortened under an open reader");
  Tally swapped;
  swap_pages(files, swapped);
  swapped.print("swapped pages");
  // Control: the comparison must see another store for what it is.
  const Files other = sample_store(2);
  const auto terrain = open_in_memory(other);
  const bool seen =
      compare(read_everything(*terrain), intact_content(files), *terrain) == Harm::Silent;
  fmt::print("control: another store {}\n", seen ? "is told apart" : "is taken for the same");
  return static_cast<int>(shorter.faults() + live.faults() + swapped.faults() + shorter.harmless +
                          (seen ? 0 : 1));
}

}  // namespace arete::torture
