#pragma once

#include "arete/core/build_context.h"
#include "arete/lod/bintree/groups.h"
#include "arete/lod/bintree/record_pages.h"
#include "arete/store/build.h"
#include "arete/store/terrain.h"

namespace arete::lod::bintree {

struct RecordOptions {
  Delta delta = Delta::Exact;
  int log2_block =
      Groups::kLog2Block;  ///< smaller for tests; decides the order of pages in the file
};

/// Writes bintree_segment(options.delta). The memory used stays within the context's limit and does
/// not grow with the terrain. Throws: Limit, Corrupt, Cancelled, Io.
void write_records(const store::Terrain& terrain, store::Writers& writers,
                   const BuildContext& context, const RecordOptions& options);

}  // namespace arete::lod::bintree
