#include "arete/lod/geomipmap/geomipmap.h"
#include "arete/lod/params.h"
#include "arete/lod/patch_table.h"

namespace arete::lod::geomipmap {

// All that the method needs beside the height pyramid is the shared error tables.
void preprocess(const store::Terrain& terrain, store::Writers& writers, const BuildContext&,
                const Params& params) {
  write_patch_table(terrain, writers,
                    parse_patch(param(params, "patch", "auto"), terrain.manifest()));
}

}  // namespace arete::lod::geomipmap
