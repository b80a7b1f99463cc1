#pragma once

#include <memory>
#include <string>
#include <vector>

#include "arete/core/heightfield.h"
#include "arete/lod/bintree/preprocess.h"
#include "arete/lod/bintree/record.h"
#include "arete/lod/bintree/vertex_index.h"
#include "arete/store/terrain.h"

#include "store/store_fixture.h"

namespace arete::lod::bintree {

/// A store of a DEM with bin-tree records, in a folder of its own that goes with it.
class RecordedTerrain {
 public:
  explicit RecordedTerrain(Heightfield dem, const RecordOptions& options = {},
                           const BuildContext& context = {});

  const Heightfield& dem() const { return dem_; }  ///< as stored
  const store::Terrain& terrain() const { return *terrain_; }
  std::filesystem::path store() const { return folder_ / "t.arete"; }

 private:
  store::TemporaryFolder folder_;
  Heightfield dem_;
  std::unique_ptr<store::Terrain> terrain_;
};

/// Every record of a domain, by post.
class AllRecords {
 public:
  AllRecords(const store::Terrain& terrain, Delta delta);
  const Domain& domain() const { return domain_; }
  Record& operator[](Post p) {
    return records_[static_cast<std::size_t>(p.row * (domain_.side() + 1) + p.col)];
  }

 private:
  Domain domain_;
  std::vector<Record> records_;
};

/// Faults of the records against the terrain, found triangle by triangle and post by post:
/// heights of drawable posts, the bound, nesting of deltas and spheres, locked vertices. Empty when
/// there are none.
std::vector<std::string> find_faults(AllRecords& records, const RecordedTerrain& recorded,
                                     Delta delta);

}  // namespace arete::lod::bintree
