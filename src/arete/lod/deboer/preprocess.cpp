#include "arete/lod/deboer/deboer.h"
#include "arete/lod/params.h"
#include "arete/lod/uniform_field.h"

namespace arete::lod::deboer {

void preprocess(const store::Terrain& terrain, store::Writers& writers, const BuildContext&,
                const Params& params) {
  write_uniform_tables(terrain, writers,
                       parse_uniform_patch(param(params, "patch", "auto"), terrain.manifest()));
}

}  // namespace arete::lod::deboer
