#pragma once

#include "arete/core/build_context.h"
#include "arete/core/height_source.h"
#include "arete/store/band_import.h"
#include "arete/store/lattice.h"
#include "arete/store/unit.h"

namespace arete::store {

/// All bands of a source, stored as units 0 .. tiles_y(0)-1 of `units`.
/// One pass over the rows: the caller's thread reads, the others encode; finished units are not
/// read again. False when a height did not fit the lattice: try again with a coarser one.
/// Throws: Cancelled, Limit when a band does not fit the memory limit, what the source throws.
bool import_bands(HeightSource& source, const Lattice& lattice, int fill_cell_posts,
                  const UnitFolder& units, const BuildContext& context);

/// The lattice for a source whose heights did not fit the first one; reads every row.
Lattice scan_for_lattice(HeightSource& source, const BuildContext& context);

}  // namespace arete::store
