#include "arete/lod/bintree/preprocess.h"

#include <algorithm>
#include <cmath>
#include <mutex>

#include <fmt/format.h>

#include "arete/core/error.h"
#include "arete/core/parallel.h"
#include "arete/lod/bintree/bintree.h"
#include "arete/lod/bintree/engine_parts.h"
#include "arete/lod/bintree/own_delta.h"
#include "arete/lod/bintree/page_codec.h"
#include "arete/lod/bintree/page_layout.h"
#include "arete/lod/bintree/post_rows.h"
#include "arete/lod/bintree/record_grid.h"

namespace arete::lod::bintree {
namespace {

// Posts are read in pieces of this size, whole tiles of the store.
constexpr int kPieceCols = 2048, kPieceRows = store::kTileCells;

// A vertex is drawn at a height rounded to float, and the true height that it is held against is
// rounded, too: half an ulp each.
double slack_of(const store::Manifest& m) {
  return std::max(std::abs(m.z_min), std::abs(m.z_max)) * 0x1p-23;
}

// Makes the blocks of one unit.
class UnitMaker {
 public:
  UnitMaker(const store::Terrain& terrain, const Groups& groups, const RecordOptions& options,
            int threads)
      : terrain_(terrain), groups_(groups), options_(options), threads_(threads) {}

  void make(int unit, store::BlockSink& sink) const {
    const BlockId block = groups_.block_of(unit);
    RecordGrid grid(terrain_, groups_, block);
    std::vector<Code> maxima(static_cast<std::size_t>(groups_.domain().depths()), 0);
    if (block.group > 0) read_finer(grid, sink, maxima);
    grid.nest(own_deltas(grid), slack_of(terrain_.manifest()));
    grid.raise_maxima(maxima);
    add_pages(grid, unit, sink);
    sink.add(page_key(unit, kMaximaPage), std::as_bytes(std::span(maxima)));
  }

 private:
  // The finer group's blocks that hold white vertices of this one's region.
  void read_finer(RecordGrid& grid, const store::BlockSink& sink, std::vector<Code>& maxima) const {
    const int finer = grid.block().group - 1;
    const int shift = grid.log2_spacing() - groups_.log2_spacing(finer);
    const int cells = groups_.block_cells(finer) >> shift;
    const PostRect& region = grid.region();
    for (int y = region.row0 / cells;
         y <= std::min((region.row1 - 1) / cells, groups_.blocks_y(finer) - 1); ++y)
      for (int x = region.col0 / cells;
           x <= std::min((region.col1 - 1) / cells, groups_.blocks_x(finer) - 1); ++x)
        read_finer_block({finer, x, y}, grid, sink, maxima);
  }

  void read_finer_block(const BlockId& finer, RecordGrid& grid, const store::BlockSink& sink,
                        std::vector<Code>& maxima) const {
    const int unit = groups_.unit_of(finer);
    const auto [first, end] = groups_.coarser_white_pages(finer);
    std::vector<Record> records(kPageRecords);
    sink.read_earlier(
        unit, page_key(unit, first), page_key(unit, end),
        [&](std::uint64_t key, std::span<const std::byte> raw) {
          require(decode_page(raw, records));
          for_each_post(groups_.domain(), page_of_key(key), [&](std::size_t slot, Post post) {
            grid.set_finer({post.col >> grid.log2_spacing(), post.row >> grid.log2_spacing()},
                           records[slot]);
          });
        });
    std::vector<Code> theirs(maxima.size());
    sink.read_earlier(unit, page_key(unit, kMaximaPage), page_key(unit, kMaximaPage) + 1,
                      [&](std::uint64_t, std::span<const std::byte> raw) {
                        require(raw.size() == theirs.size() * sizeof(Code));
                        std::ranges::copy(raw, std::as_writable_bytes(std::span(theirs)).begin());
                      });
    for (std::size_t i = 0; i < maxima.size(); ++i) maxima[i] = std::max(maxima[i], theirs[i]);
  }

  void require(bool whole) const {
    if (!whole)
      throw Error(ErrorCode::Corrupt,
                  terrain_.name() + ": a finished piece of its bin-tree is wrong: build again");
  }

  OwnDeltas own_deltas(RecordGrid& grid) const {
    OwnDeltas own(grid.size(), 0.0);
    if (grid.log2_spacing() == 0 || options_.delta == Delta::Exact) read_posts(grid, own);
    if (options_.delta == Delta::Incremental) raise_incremental(grid, own);
    return own;
  }

  // The last block is alone in its phase, so its threads share the terrain.
  void read_posts(RecordGrid& grid, OwnDeltas& own) const {
    const PostRect& region = grid.region();
    const int s = grid.log2_spacing();
    const PostRect posts{region.col0 << s, region.row0 << s, ((region.col1 - 1) << s) + 1,
                         ((region.row1 - 1) << s) + 1};
    const PostRect land{posts.col0, posts.row0, std::min(posts.col1, terrain_.manifest().cols),
                        std::min(posts.row1, terrain_.manifest().rows)};
    const int first = land.row0 / kPieceRows;
    const int pieces = land.empty() ? 0 : (land.row1 - 1) / kPieceRows + 1 - first;
    const int threads =
        std::clamp(groups_.is_last(grid.block().group) ? threads_ : 1, 1, std::max(pieces, 1));
    std::vector<OwnDeltas> parts(static_cast<std::size_t>(threads - 1),
                                 OwnDeltas(threads > 1 ? own.size() : 0, 0.0));
    parallel_for(threads, threads, [&](int t) {
      OwnDeltas& to = t == 0 ? own : parts[static_cast<std::size_t>(t - 1)];
      PostRows rows;
      for (int piece = t; piece < pieces; piece += threads)
        read_piece(grid, land, (first + piece) * kPieceRows, rows, to);
    });
    for (const OwnDeltas& part : parts)
      for (std::size_t i = 0; i < own.size(); ++i) own[i] = std::max(own[i], part[i]);
  }

  void read_piece(RecordGrid& grid, const PostRect& land, int row, PostRows& rows,
                  OwnDeltas& own) const {
    for (int col = land.col0 / kPieceCols * kPieceCols; col < land.col1; col += kPieceCols) {
      rows.load(terrain_,
                {std::max(col, land.col0), std::max(row, land.row0),
                 std::min(col + kPieceCols, land.col1), std::min(row + kPieceRows, land.row1)});
      if (grid.log2_spacing() == 0) set_counted(rows, grid);
      if (options_.delta == Delta::Exact) raise_exact(grid, rows, own);
    }
  }

  static void set_counted(const PostRows& rows, RecordGrid& grid) {
    const PostRect& rect = rows.rect();
    for (int r = rect.row0; r < rect.row1; ++r) {
      const double* z = rows.row(r);
      for (int c = rect.col0; c < rect.col1; ++c)
        if (!std::isnan(z[c - rect.col0])) grid.set_counted({c, r});
    }
  }

  void add_pages(const RecordGrid& grid, int unit, store::BlockSink& sink) const {
    std::vector<Record> records;
    std::vector<std::byte> raw;
    for (const std::uint64_t page : groups_.pages(grid.block())) {
      records.assign(kPageRecords, {});
      for_each_post(groups_.domain(), page, [&](std::size_t slot, Post post) {
        records[slot] = grid[{post.col >> grid.log2_spacing(), post.row >> grid.log2_spacing()}];
      });
      const bool any = std::ranges::any_of(
          records, [](const Record& r) { return r.count != 0 || r.radius != 0; });
      if (!any) continue;
      encode_page(records, raw);
      sink.add(page_key(unit, page), raw);
    }
  }

  const store::Terrain& terrain_;
  const Groups& groups_;
  RecordOptions options_;
  int threads_;
};

// Records, own deltas, finer records, lattice counts, and a piece of posts.
std::size_t unit_bytes(const Groups& groups) {
  const PostRect region = groups.region({0, 0, 0});
  const auto posts = static_cast<std::size_t>(region.col1 - region.col0) *
                     static_cast<std::size_t>(region.row1 - region.row0);
  return posts * (2 * sizeof(Record) + sizeof(double) + 2 * sizeof(std::int32_t)) +
         (kPieceCols + 2) * (kPieceRows + 2) * (sizeof(double) + sizeof(std::int32_t) + 1);
}

}  // namespace

void write_records(const store::Terrain& terrain, store::Writers& writers,
                   const BuildContext& context, const RecordOptions& options) {
  const store::Manifest& m = terrain.manifest();
  if (!Domain::fits(m.cols, m.rows))
    throw Error(ErrorCode::Limit,
                fmt::format("{}: {} x {} posts: soar and smart take at most {} a side: leave them "
                            "out of --methods",
                            m.source, m.cols, m.rows, (1 << Domain::kMaxLog2Cells) + 1));
  const Groups groups(m.cols, m.rows, options.log2_block);
  const UnitMaker maker(terrain, groups, options, context.threads);
  store::SegmentPlan plan;
  plan.name = bintree_segment(options.delta);
  plan.params =
      fmt::format("bintree-records 1 {} block={}",
                  options.delta == Delta::Exact ? "exact" : "incremental", 1 << options.log2_block);
  plan.units = groups.units();
  plan.make = [&maker](int unit, store::BlockSink& sink) { maker.make(unit, sink); };
  for (int g = 1; g < groups.count(); ++g) plan.later_phases.push_back(groups.first_unit(g));
  plan.unit_bytes = unit_bytes(groups);
  writers.write(plan);
}

void preprocess(const store::Terrain& terrain, store::Writers& writers, const BuildContext& context,
                const Params& params) {
  write_records(terrain, writers, context, {.delta = delta_param(params)});
}

}  // namespace arete::lod::bintree
