#include "arete/mesh/edges.h"

#include <algorithm>
#include <numeric>

#include "arete/mesh/key_index.h"

namespace arete::mesh {
namespace {

std::uint64_t pack(std::uint32_t high, std::uint32_t low) {
  return (std::uint64_t{high} << 32U) | low;
}

std::uint64_t post_key(Post p) {
  return pack(static_cast<std::uint32_t>(p.row), static_cast<std::uint32_t>(p.col));
}

Post post_of(std::uint64_t key) {
  return {static_cast<std::int32_t>(static_cast<std::uint32_t>(key)),
          static_cast<std::int32_t>(static_cast<std::uint32_t>(key >> 32U))};
}

bool same_place(const SurfaceVertex& a, const SurfaceVertex& b) {
  return a.z == b.z && a.dcol == b.dcol && a.drow == b.drow;  // false for NaN
}

// How often an edge is used each way between its ends, lower post number first.
struct Uses {
  std::uint32_t forward = 0, backward = 0;
  std::int64_t net() const { return std::int64_t{forward} - std::int64_t{backward}; }
};

// Edges by the numbers of their end posts, counted by direction.
class EdgeCounter {
 public:
  explicit EdgeCounter(std::size_t expected_edges) : edges_(expected_edges) {
    uses_.reserve(expected_edges);
  }

  void add(std::uint32_t from, std::uint32_t to, std::uint32_t times = 1) {
    const bool forward = from < to;
    const std::uint32_t e = edges_.find_or_add(forward ? pack(from, to) : pack(to, from));
    if (e == uses_.size()) uses_.emplace_back();
    (forward ? uses_[e].forward : uses_[e].backward) += times;
  }

  std::size_t size() const { return uses_.size(); }
  Uses uses(std::size_t e) const { return uses_[e]; }
  std::uint32_t low(std::size_t e) const {
    return static_cast<std::uint32_t>(edges_.key(e) >> 32U);
  }
  std::uint32_t high(std::size_t e) const { return static_cast<std::uint32_t>(edges_.key(e)); }

 private:
  KeyIndex edges_;
  std::vector<Uses> uses_;
};

// Post numbers of the vertices; counts the posts that are drawn at two places.
std::vector<std::uint32_t> number_posts(const Surface& s, KeyIndex& posts, EdgeReport& report) {
  std::vector<std::uint32_t> number(s.vertices.size());
  std::vector<std::uint32_t> first;  // post number -> first vertex there
  std::vector<char> torn;
  for (std::size_t v = 0; v < s.vertices.size(); ++v) {
    const std::uint32_t p = posts.find_or_add(post_key(s.vertices[v].post));
    number[v] = p;
    if (p == first.size()) {
      first.push_back(static_cast<std::uint32_t>(v));
      torn.push_back(0);
    }
    if (torn[p] == 0 && !same_place(s.vertices[first[p]], s.vertices[v])) {
      torn[p] = 1;
      ++report.height_mismatches;
    }
  }
  return number;
}

void count_edges(const Surface& s, const std::vector<std::uint32_t>& number, EdgeCounter& edges,
                 EdgeReport& report) {
  for (std::size_t i = 0; i + 3 <= s.indices.size(); i += 3) {
    const std::uint32_t a = s.indices[i];
    const std::uint32_t b = s.indices[i + 1];
    const std::uint32_t c = s.indices[i + 2];
    const std::int64_t area =
        doubled_area(s.vertices[a].post, s.vertices[b].post, s.vertices[c].post);
    if (area <= 0) ++report.flipped;
    if (area == 0) continue;
    edges.add(number[a], number[b]);
    edges.add(number[b], number[c]);
    edges.add(number[c], number[a]);
  }
}

// Cuts the part of an edge that found no opposite into steps between lattice points.
void cut(Post a, Post b, std::uint32_t times, KeyIndex& posts, EdgeCounter& pieces) {
  const std::int32_t n = std::gcd(b.col - a.col, b.row - a.row);
  const Post step{(b.col - a.col) / n, (b.row - a.row) / n};
  std::uint32_t from = posts.find_or_add(post_key(a));
  for (std::int32_t k = 1; k <= n; ++k) {
    const std::uint32_t to =
        posts.find_or_add(post_key({a.col + k * step.col, a.row + k * step.row}));
    pieces.add(from, to, times);
    from = to;
  }
}

}  // namespace

std::int64_t doubled_area(Post a, Post b, Post c) {
  const std::int64_t bc = std::int64_t{b.col} - a.col;
  const std::int64_t br = std::int64_t{b.row} - a.row;
  const std::int64_t cc = std::int64_t{c.col} - a.col;
  const std::int64_t cr = std::int64_t{c.row} - a.row;
  return br * cc - bc * cr;  // rows run south
}

EdgeReport match_edges(const Surface& surface) {
  EdgeReport report;
  KeyIndex posts(surface.vertices.size());
  EdgeCounter edges(surface.indices.size() / 2 + 16);
  count_edges(surface, number_posts(surface, posts, report), edges, report);

  EdgeCounter pieces(1024);
  for (std::size_t e = 0; e < edges.size(); ++e) {
    const Uses u = edges.uses(e);
    report.overlaps += std::max(u.forward, 1U) - 1 + std::max(u.backward, 1U) - 1;
    if (u.net() == 0) continue;
    const Post low = post_of(posts.key(edges.low(e)));
    const Post high = post_of(posts.key(edges.high(e)));
    const auto times = static_cast<std::uint32_t>(std::abs(u.net()));
    u.net() > 0 ? cut(low, high, times, posts, pieces) : cut(high, low, times, posts, pieces);
  }
  for (std::size_t e = 0; e < pieces.size(); ++e) {
    const Uses u = pieces.uses(e);
    report.t_junctions += std::min(u.forward, u.backward);
    if (u.net() == 0) continue;
    report.boundary.push_back({post_of(posts.key(pieces.low(e))),
                               post_of(posts.key(pieces.high(e))), static_cast<int>(u.net())});
  }
  return report;
}

}  // namespace arete::mesh
