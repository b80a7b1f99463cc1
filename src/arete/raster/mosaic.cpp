#include "arete/raster/mosaic.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "arete/core/error.h"
#include "arete/core/post.h"

namespace arete::raster {
namespace {

constexpr double kSpacingTolerance = 1e-6;
constexpr double kAlignmentTolerancePosts = 1e-3;
constexpr double kFarthestPost = 1 << 30;

struct Member {
  std::unique_ptr<DemFile> file;
  PostRect rect;  ///< in posts of the mosaic
};

[[noreturn]] void refuse(const DemFile& file, const DemFile& first, const char* what) {
  throw Error(ErrorCode::InvalidInput,
              fmt::format("{}: {} differs from that of {}: bring both to one grid first "
                          "(gdalwarp -tap -tr)",
                          file.name(), what, first.name()));
}

std::optional<OGRSpatialReference> crs_of(const DemFile& file) {
  const std::string wkt = file.georef().crs;
  return wkt.empty() ? std::nullopt : std::optional(parse_crs(wkt, file.name()));
}

void check_same_grid(const DemFile& file, const DemFile& first) {
  const Georef a = first.georef(), b = file.georef();
  if (a.crs != b.crs) {
    const auto one = crs_of(first), other = crs_of(file);
    if (!one || !other || one->IsSame(&*other) == 0) refuse(file, first, "its CRS");
  }
  const auto& m = a.crs_from_post.m;
  const double spacing = std::min(std::hypot(m[0], m[3]), std::hypot(m[1], m[4]));
  for (const std::size_t k : {0U, 1U, 3U, 4U}) {
    if (std::abs(m[k] - b.crs_from_post.m[k]) > kSpacingTolerance * spacing) {
      refuse(file, first, "its spacing");
    }
  }
}

// Longitudes are the same modulo a turn: the one nearest to the first file's is taken.
double turns_to(double x, double reference, const std::optional<OGRSpatialReference>& crs) {
  if (!crs || crs->IsGeographic() == 0) return 0;
  const double turn = 2 * M_PI / crs->GetAngularUnits();
  return std::round((reference - x) / turn) * turn;
}

// Where the file's posts lie in the first one's grid.
PostRect locate(const DemFile& file, const DemFile& first) {
  const Affine2 grid = first.georef().crs_from_post;
  const Affine2 own = file.georef().crs_from_post;
  const auto crs = crs_of(first);
  const glm::ivec2 last(file.cols() - 1, file.rows() - 1);
  const glm::dvec2 centre = own.apply(last.x / 2.0, last.y / 2.0);
  const double reference = grid.apply(first.cols() / 2.0, first.rows() / 2.0).x;
  const glm::dvec2 shift(turns_to(centre.x, reference, crs), 0);
  const glm::dvec2 begin = grid.inverse(own.apply(0, 0) + shift);
  const glm::dvec2 end = grid.inverse(own.apply(last.x, last.y) + shift);
  const glm::dvec2 at = glm::round(begin);
  const auto off = [](glm::dvec2 d) { return std::max(std::abs(d.x), std::abs(d.y)); };
  if (std::max(off(begin - at), off(end - at - glm::dvec2(last))) > kAlignmentTolerancePosts) {
    refuse(file, first, "its alignment (a part of a post)");
  }
  if (!(off(at) < kFarthestPost)) refuse(file, first, "its place, far away,");
  const auto col = static_cast<int>(at.x), row = static_cast<int>(at.y);
  return {col, row, col + file.cols(), row + file.rows()};
}

class Mosaic final : public HeightSource {
 public:
  Mosaic(std::vector<Member> members, Georef georef, int cols, int rows)
      : members_(std::move(members)), georef_(std::move(georef)), cols_(cols), rows_(rows) {
    counted_.resize(static_cast<std::size_t>(rows));
  }

  int cols() const override { return cols_; }
  int rows() const override { return rows_; }

  Georef georef() const override {
    Georef georef = georef_;
    georef.notes = member_notes();
    if (differing_ > 0) {
      georef.notes.push_back(
          fmt::format("{} posts that two files share differ, by up to {:.3g} m: the file named "
                      "first was taken.",
                      differing_, largest_m_));
    }
    return georef;
  }

  HeightLattice lattice() const override {
    const HeightLattice first = members_.front().file->lattice();
    for (const Member& member : members_) {
      const HeightLattice other = member.file->lattice();
      if (other.integer != first.integer || other.step_m != first.step_m ||
          other.offset_m != first.offset_m) {
        return {};
      }
    }
    return first;
  }

  std::string description() const override {
    return fmt::format("{} and {} more ({} x {}, mosaic)", members_.front().file->name(),
                       members_.size() - 1, cols_, rows_);
  }

  void read_row(int r, std::span<float> row) override {
    std::fill(row.begin(), row.end(), std::numeric_limits<float>::quiet_NaN());
    for (Member& member : members_) {
      if (r < member.rect.row0 || r >= member.rect.row1) {
        if (member.file->holds_memory()) member.file->release();
        continue;
      }
      part_.resize(static_cast<std::size_t>(member.file->cols()));
      member.file->read_row(r - member.rect.row0, part_);
      lay(r, row.subspan(static_cast<std::size_t>(member.rect.col0), part_.size()));
    }
    counted_[static_cast<std::size_t>(r)] = true;
  }

 private:
  // Puts part_ under what is there already.
  void lay(int r, std::span<float> row) {
    const bool count = !counted_[static_cast<std::size_t>(r)];
    for (std::size_t i = 0; i < row.size(); ++i) {
      if (std::isnan(row[i])) {
        row[i] = part_[i];
      } else if (count && !std::isnan(part_[i]) && part_[i] != row[i]) {
        ++differing_;
        largest_m_ = std::max(largest_m_, std::abs(static_cast<double>(part_[i]) - row[i]));
      }
    }
  }

  // What several files say alike is said once.
  std::vector<std::string> member_notes() const {
    std::map<std::string, std::vector<std::string>> files_of;
    for (const Member& member : members_) {
      for (const std::string& note : member.file->georef().notes) {
        files_of[note].push_back(member.file->name());
      }
    }
    std::vector<std::string> notes;
    for (const auto& [note, files] : files_of) {
      const std::string who = files.size() == 1
                                  ? files.front()
                                  : fmt::format("{} and {} more", files.front(), files.size() - 1);
      notes.push_back(fmt::format("{}: {}", who, note));
    }
    return notes;
  }

  std::vector<Member> members_;
  Georef georef_;
  int cols_, rows_;
  std::vector<bool> counted_;  ///< rows whose differences are counted
  std::int64_t differing_ = 0;
  double largest_m_ = 0;
  std::vector<float> part_;
};

PostRect hull(const std::vector<Member>& members) {
  PostRect all = members.front().rect;
  for (const Member& member : members) {
    all.col0 = std::min(all.col0, member.rect.col0);
    all.row0 = std::min(all.row0, member.rect.row0);
    all.col1 = std::max(all.col1, member.rect.col1);
    all.row1 = std::max(all.row1, member.rect.row1);
  }
  return all;
}

// The most files that any row of the mosaic crosses.
std::size_t most_in_a_row(const std::vector<Member>& members) {
  std::map<int, int> begun;  // how many more files there are from this row on
  for (const Member& member : members) {
    ++begun[member.rect.row0];
    --begun[member.rect.row1];
  }
  int now = 0, most = 1;
  for (const auto& [row, more] : begun) most = std::max(most, now += more);
  return static_cast<std::size_t>(most);
}

Georef georef_of(const DemFile& first, const PostRect& all) {
  Georef georef = first.georef();
  georef.notes.clear();
  const glm::dvec2 origin = georef.crs_from_post.apply(all.col0, all.row0);
  georef.crs_from_post.m[2] = origin.x;
  georef.crs_from_post.m[5] = origin.y;
  const auto crs = crs_of(first);
  fill_world(georef, all.col1 - all.col0, all.row1 - all.row0, crs ? &*crs : nullptr);
  return georef;
}

}  // namespace

std::unique_ptr<HeightSource> make_mosaic(std::vector<std::unique_ptr<DemFile>> files, int max_side,
                                          std::size_t buffer_bytes) {
  const DemFile& first = *files.front();
  std::vector<Member> members;
  for (std::unique_ptr<DemFile>& file : files) {
    if (!file->located()) {
      throw Error(ErrorCode::InvalidInput,
                  fmt::format("{}: does not say where it lies: a mosaic needs files with a "
                              "geotransform",
                              file->name()));
    }
    check_same_grid(*file, first);
    const PostRect rect = locate(*file, first);
    members.push_back({std::move(file), rect});
  }
  const PostRect all = hull(members);
  const std::int64_t cols = std::int64_t{all.col1} - all.col0;
  const std::int64_t rows = std::int64_t{all.row1} - all.row0;
  if (cols > max_side || rows > max_side) {
    throw Error(
        ErrorCode::Limit,
        fmt::format("{}: with the others {} x {} posts, over {} a side: build fewer at once",
                    first.name(), cols, rows, max_side));
  }
  for (Member& member : members) {
    PostRect& rect = member.rect;
    rect = {rect.col0 - all.col0, rect.row0 - all.row0, rect.col1 - all.col0, rect.row1 - all.row0};
  }
  const std::size_t share = buffer_bytes / most_in_a_row(members);
  for (const Member& member : members) member.file->read_in_chunks_of(share);
  Georef georef = georef_of(first, all);
  return std::make_unique<Mosaic>(std::move(members), std::move(georef), static_cast<int>(cols),
                                  static_cast<int>(rows));
}

}  // namespace arete::raster
