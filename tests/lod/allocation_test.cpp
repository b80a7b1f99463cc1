// A program of its own: it counts every allocation, which does not go with OpenGL drivers in one
// process.
#include <atomic>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <new>

#include <gtest/gtest.h>

#include "arete/lod/bintree/record_pages.h"
#include "arete/lod/engine.h"

#include "lod/built_terrain.h"
#include "lod/variants.h"

namespace {
std::atomic<std::uint64_t> allocations{0};
thread_local std::uint64_t own_allocations = 0;
}  // namespace

// Counts every allocation of this test program: refine must make none once warm.
[[gnu::noinline]] void* operator new(std::size_t size) {
  ++allocations;
  ++own_allocations;
  if (void* p = std::malloc(size)) return p;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* p) noexcept {
  std::free(p);
}
[[gnu::noinline]] void operator delete(void* p, std::size_t) noexcept {
  std::free(p);
}

namespace arete::lod {
namespace {

TEST(Allocation, RefineAllocatesNothingOnceWarm) {
  const BuiltTerrain terrain(rough_dem(257, 193, 1, 0.1), {{"patch", "17"}});
  const auto opened = terrain.open();
  for (const Variant& tested : variants()) {
    SCOPED_TRACE(tested.name);
    const auto engine = tested.open(*opened, "17");
    DrawList list;
    // Three rounds: smart's arrays grow at a collection, and those come some rounds apart.
    for (int k = 0; k < 600; ++k) engine->refine(flight_view(k % 200 / 200.0), {}, list);
    const std::uint64_t before = allocations;
    for (int k = 0; k < 200; ++k) engine->refine(flight_view(k / 200.0), {}, list);
    EXPECT_EQ(allocations - before, 0U);
  }
  const std::uint64_t before = allocations;
  ::operator delete(::operator new(1));  // the control: the counter counts
  EXPECT_EQ(allocations - before, 1U);
}

// Of the frames' own thread: what reads pages may.
TEST(Allocation, AskingForPagesAllocatesNothingOnceWarm) {
  const BuiltTerrain terrain(rough_dem(257, 193, 1, 0.1), {{"patch", "17"}});
  const auto opened = terrain.open();
  bintree::RecordPages pages(*opened, {.budget_bytes = 16 * bintree::kRecordPageBytes});
  std::vector<std::uint64_t> missing(4), ahead(4);
  std::uint64_t missed = 0;
  const auto fly = [&](unsigned frames) {
    for (unsigned i = 0; i < frames; ++i) {
      pages.begin_frame();
      for (std::size_t k = 0; k < missing.size(); ++k) {
        const auto v = pages.domain().index_of(
            {static_cast<int>((37 * i + 60 * k) % 257), static_cast<int>((11 * i + 90 * k) % 193)});
        missing[k] = bintree::RecordPages::page_of(v);
        ahead[k] = bintree::RecordPages::page_of((v + 1000) % pages.domain().index_end());
        if (pages.find(v, OnMissing::Defer) == nullptr) ++missed;
      }
      pages.ask(missing, ahead);
    }
  };
  fly(500);
  const std::uint64_t before = own_allocations, missed_before = missed;
  fly(500);
  EXPECT_EQ(own_allocations - before, 0U);
  EXPECT_GT(missed, missed_before);
  ::operator delete(::operator new(1));  // the control: the counter counts
  EXPECT_EQ(own_allocations - before, 1U);
}

}  // namespace
}  // namespace arete::lod
