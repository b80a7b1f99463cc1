#include "arete/store/import.h"

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <vector>

#include <fmt/format.h>

#include "arete/core/error.h"
#include "arete/store/work.h"

namespace arete::store {
namespace {

std::size_t band_bytes(int cols) {
  return static_cast<std::size_t>(cols) * kTilePosts * sizeof(std::int32_t);
}

// Bands on their way from the reading thread to the encoding ones. Buffers are few and reused: with
// none free the reading thread encodes a band itself.
class BandQueue {
 public:
  using Encode = std::function<void(const SourceBand&)>;

  BandQueue(int threads, std::size_t buffers, Encode encode) : encode_(std::move(encode)) {
    free_.resize(buffers);
    for (int t = 1; t < threads; ++t) workers_.emplace_back([this] { work(); });
  }
  BandQueue(const BandQueue&) = delete;
  BandQueue& operator=(const BandQueue&) = delete;
  ~BandQueue() { close(); }

  SourceBand take_buffer() {
    std::unique_lock lock(mutex_);
    while (true) {
      if (failure_) std::rethrow_exception(failure_);
      if (!free_.empty()) {
        SourceBand band = std::move(free_.back());
        free_.pop_back();
        return band;
      }
      if (full_.empty())
        changed_.wait(lock);
      else
        encode_one(lock);
    }
  }
  void push(SourceBand band) {
    {
      const std::scoped_lock lock(mutex_);
      full_.push_back(std::move(band));
    }
    changed_.notify_all();
  }
  // Encodes what is left and hands on the first failure.
  void finish() {
    {
      std::unique_lock lock(mutex_);
      while (!full_.empty() && !failure_) encode_one(lock);
    }
    close();
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  void close() {
    {
      const std::scoped_lock lock(mutex_);
      closed_ = true;
    }
    changed_.notify_all();
    workers_.clear();
  }
  void work() {
    std::unique_lock lock(mutex_);
    while (true) {
      changed_.wait(lock, [this] { return closed_ || !full_.empty() || failure_; });
      if (full_.empty() || failure_) return;
      encode_one(lock);
    }
  }
  void encode_one(std::unique_lock<std::mutex>& lock) {
    SourceBand band = std::move(full_.front());
    full_.pop_front();
    lock.unlock();
    std::exception_ptr failure;
    try {
      encode_(band);
    } catch (...) {
      failure = std::current_exception();
    }
    lock.lock();
    if (!failure_) failure_ = failure;
    free_.push_back(std::move(band));
    changed_.notify_all();
  }

  Encode encode_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<SourceBand> free_;
  std::deque<SourceBand> full_;
  std::exception_ptr failure_;
  bool closed_ = false;
  std::vector<std::jthread> workers_;
};

// Reads bands in order. The last row of one is the first of the next and is read once.
class BandReader {
 public:
  BandReader(HeightSource& source, const Lattice& lattice)
      : source_(source),
        shape_{source.cols(), source.rows()},
        lattice_(lattice),
        row_(static_cast<std::size_t>(shape_.cols)) {}

  // False when a height does not fit the lattice.
  bool read(int y, SourceBand& band) {
    const auto cols = static_cast<std::size_t>(shape_.cols);
    const int first = y * kTileCells;
    band.y = y;
    band.rows = std::min(kTilePosts, shape_.rows - first);
    band.counts.resize(cols * kTilePosts);
    band.stats = {};
    const int owned = owned_rows(shape_, y);
    for (int r = 0; r < band.rows; ++r) {
      const auto counts = std::span(band.counts).subspan(static_cast<std::size_t>(r) * cols, cols);
      if (first + r != carried_row_) {
        carried_stats_ = {};
        source_.read_row(first + r, row_);
        if (!quantize_row(lattice_, row_, counts, carried_stats_)) return false;
      } else {
        std::ranges::copy(carried_, counts.begin());
      }
      if (r < owned) band.stats.merge(carried_stats_);
    }
    carried_row_ = first + band.rows - 1;
    const auto last =
        std::span(band.counts).subspan(static_cast<std::size_t>(band.rows - 1) * cols);
    carried_.assign(last.begin(), last.begin() + shape_.cols);
    return true;
  }

 private:
  HeightSource& source_;
  PyramidShape shape_;
  Lattice lattice_;
  std::vector<float> row_;
  std::vector<std::int32_t> carried_;
  RowStats carried_stats_;  // of the row read last
  int carried_row_ = -1;
};

// Buffers for all threads and one to read into, within half the memory limit.
std::size_t buffer_count(const HeightSource& source, const BuildContext& context) {
  const int cols = source.cols();
  constexpr std::size_t kLeast = 2;
  const std::size_t fit = context.memory_limit / 2 / band_bytes(cols);
  if (fit < kLeast)
    throw Error(ErrorCode::Limit,
                fmt::format("{}: its rows need a memory limit of {} MiB: raise --memory-limit",
                            source.description(), (2 * kLeast * band_bytes(cols) >> 20U) + 1));
  return std::clamp(static_cast<std::size_t>(std::max(context.threads, 1)) + 1, kLeast, fit);
}

}  // namespace

bool import_bands(HeightSource& source, const Lattice& lattice, int fill_cell_posts,
                  const UnitFolder& units, const BuildContext& context) {
  const PyramidShape shape{source.cols(), source.rows()};
  StepProgress progress(context, "import", shape.tiles_y(0));
  BandReader reader(source, lattice);
  BandQueue queue(context.threads, buffer_count(source, context), [&](const SourceBand& band) {
    units.make(band.y, [&](UnitWriter& unit) { store_band(shape, fill_cell_posts, band, unit); });
  });
  for (int y = 0; y < shape.tiles_y(0); ++y) {
    if (!units.is_finished(y)) {
      SourceBand band = queue.take_buffer();
      if (!reader.read(y, band)) return false;
      queue.push(std::move(band));
    }
    progress.add_one();
  }
  queue.finish();
  return true;
}

Lattice scan_for_lattice(HeightSource& source, const BuildContext& context) {
  StepProgress progress(context, "scan heights", source.rows());
  std::vector<float> row(static_cast<std::size_t>(source.cols()));
  std::vector<std::int32_t> counts(row.size());
  RowStats stats;
  for (int r = 0; r < source.rows(); ++r) {
    source.read_row(r, row);
    quantize_row(first_lattice({}), row, counts, stats);
    progress.add_one();
  }
  return lattice_for_magnitude(stats.z_abs_max);
}

}  // namespace arete::store
