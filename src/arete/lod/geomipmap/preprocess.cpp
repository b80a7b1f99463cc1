#include "arete/lod/geomipmap/geomipmap.h"
#include "arete/lod/params.h"
#include "arete/lod/patch_table.h"
#include "arete/lod/uniform_field.h"

namespace arete::lod::geomipmap {

// All that the method needs beside the height pyramid is the shared error tables; its literal form,
// max-error vertices too.
void preprocess(const store::Terrain& terrain, store::Writers& writers, const BuildContext&,
                const Params& params) {
  const std::string_view patch = param(params, "patch", "auto");
  write_patch_table(terrain, writers, parse_patch(patch, terrain.manifest()));
  if (flag_param(params, "literal"))
    write_uniform_tables(terrain, writers, parse_uniform_patch(patch, terrain.manifest()));
}

}  // namespace arete::lod::geomipmap
