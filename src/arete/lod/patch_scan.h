#pragma once

#include <functional>

#include "arete/lod/error_tables.h"
#include "arete/store/build.h"
#include "arete/store/terrain.h"

namespace arete::lod {

/// Patches of 2^w cells along `posts` posts.
int patches_along(int posts, int log2_cells);

/// A patch's heights while tables are made; null when it has no drawable cell.
using PatchRecorder = std::function<void(const PatchHeights* patch)>;

/// One segment of records a patch: a unit and a block for each row of height tiles, its records row
/// by row of patches. `make_recorder` gives, for a unit, what appends a record to `bytes`.
/// Thread contract: it is called from several threads at once.
void write_patch_records(
    const store::Terrain& terrain, store::Writers& writers, const store::SegmentPlan& named,
    int log2_cells,
    const std::function<PatchRecorder(std::vector<std::byte>& bytes)>& make_recorder);

/// Calls read(patch, record) for every patch of a segment so written.
/// Throws: Corrupt when a block is missing, damaged or of another size.
void read_patch_records(const store::Terrain& terrain, const std::string& segment, int log2_cells,
                        std::size_t record_size,
                        const std::function<void(int patch, const std::byte* record)>& read);

}  // namespace arete::lod
