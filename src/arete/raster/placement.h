#pragma once

#include <optional>
#include <string>

#include <gdal_priv.h>
#include <ogr_spatialref.h>

#include "arete/core/georef.h"

namespace arete::raster {

/// Where a grid lies and how its rows and columns are to be turned so that row 0 is north and
/// column 0 west.
struct Placement {
  Georef georef;
  bool flip_rows = false, flip_cols = false;
  bool located = true;  ///< false: the file does not say where it lies
};

/// A CRS from "EPSG:N", WKT or PROJ text, x (longitude) first. No file and no network is asked.
/// Throws: InvalidInput naming `name`.
OGRSpatialReference parse_crs(const std::string& text, const std::string& name);

/// Placement of an open file; `source_crs`, if not empty, replaces the file's. A missing or
/// impossible geotransform gives posts 1 m apart and a note.
Placement place(GDALDataset& dataset, const std::string& source_crs, const std::string& name);

/// The file's own affine, (0,0) the centre of its first pixel; nothing when it has none that could
/// be one.
std::optional<Affine2> pixel_centres(GDALDataset& dataset);

/// Fills world_from_post, crs and crs_name for a grid whose crs_from_post is set; nullptr = no CRS,
/// units are metres.
void fill_world(Georef& georef, int cols, int rows, const OGRSpatialReference* crs);

/// Posts 1 m apart, row 0 north, no CRS.
Georef unit_georef();

}  // namespace arete::raster
