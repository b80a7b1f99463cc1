#pragma once

#include "arete/core/height_source.h"
#include "arete/store/store_builder.h"

namespace arete::store {

/// Makes the heights segment of `builder` from a source and fills in what its manifest says of
/// heights. A finished segment of an interrupted build is kept.
void build_heights(HeightSource& source, StoreBuilder& builder);

}  // namespace arete::store
