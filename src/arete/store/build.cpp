#include "arete/store/build.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "arete/core/error.h"
#include "arete/store/drape.h"
#include "arete/store/hash.h"
#include "arete/store/height_rows.h"
#include "arete/store/heights_build.h"
#include "arete/store/manifest.h"
#include "arete/store/part_directory.h"
#include "arete/store/publish.h"
#include "arete/store/raster_build.h"
#include "arete/store/raster_pyramid.h"
#include "arete/store/store_builder.h"

namespace arete::store {
namespace {

namespace fs = std::filesystem;

std::unique_ptr<Terrain> open_quietly(const fs::path& store) {
  OpenOptions options;
  options.prefetch = false;
  return Terrain::open(store, options);
}

void check_source(const HeightSource& source) {
  const auto sized = [](int n) { return n >= 1 && n <= kMaxSide; };
  if (!sized(source.cols()) || !sized(source.rows()))
    throw Error(ErrorCode::InvalidInput,
                fmt::format("{}: {} x {} posts: a store takes 1 to {} a side", source.description(),
                            source.cols(), source.rows(), kMaxSide));
  const Affine2 world = source.georef().world_from_post;
  const bool finite = std::ranges::all_of(world.m, [](double v) { return std::isfinite(v); });
  if (!finite || !std::isnormal(world.determinant()))
    throw Error(
        ErrorCode::InvalidInput,
        source.description() + ": posts have no finite spacing: give --crs or mend the file");
}

// A store of the same heights may be added to; anything else must be asked for by name.
void require_same_heights(HeightSource& source, const fs::path& store) {
  const auto terrain = open_quietly(store);
  const Manifest& m = terrain->manifest();
  const auto stored = terrain->height_source();
  bool same = m.cols == source.cols() && m.rows == source.rows() &&
              m.georef.world_from_post == source.georef().world_from_post;
  std::vector<float> was(static_cast<std::size_t>(m.cols));
  std::vector<float> is(was.size());
  for (int r = 0; same && r < m.rows; ++r) {
    stored->read_row(r, was);
    source.read_row(r, is);
    for (std::size_t c = 0; c < was.size(); ++c)
      same = same && (std::isnan(was[c]) ||
                      std::abs(static_cast<double>(was[c]) - is[c]) <= m.max_store_error_m);
  }
  if (!same)
    throw Error(ErrorCode::Usage,
                store.string() + ": holds another terrain: choose another output or use --force");
}

void write_derived(const std::string& name, const RasterRecipe& recipe,
                   const SegmentReader& heights, StoreBuilder& builder) {
  const std::string params = raster_params(recipe.shape, "of heights " + heights.id());
  if (const auto finished = builder.find_finished(name); finished && finished->params() == params)
    return builder.record(*finished);
  const PyramidShape shape{builder.manifest.cols, builder.manifest.rows};
  const UnitFolder folder = builder.units(name, params);
  const int units = make_raster_units(recipe, shape, tiles_of(heights), folder, builder.context());
  builder.assemble_all(folder, units, name, params);
}

// Normals, and the mask where some post has no data.
void build_shading(StoreBuilder& builder) {
  const auto heights = builder.open_segment("heights");
  const Manifest& m = builder.manifest;
  const PyramidShape shape{m.cols, m.rows};
  if (m.nodata_share > 0) write_derived("mask", mask_recipe(shape), *heights, builder);
  write_derived("normals", normals_recipe(shape, m.georef.world_from_post, m.quantum_m), *heights,
                builder);
}

void make_store(HeightSource& source, const BuildOptions& options, StoreBuilder& builder) {
  builder.manifest.georef = source.georef();
  builder.manifest.source = source.description();
  build_heights(source, builder);
  build_shading(builder);
  if (options.drape != nullptr) write_drape(*options.drape, builder);
  const Terrain& terrain = builder.open_terrain();
  if (options.preprocess) options.preprocess(terrain, builder);
  builder.manifest.methods = options.methods;
  builder.finish();
}

// A refused build leaves nothing; a cancelled one what it needs to go on.
void in_part_directory(const fs::path& output, const std::string& key,
                       const std::function<void(PartDirectory&)>& work) {
  PartDirectory part(output, key);
  try {
    work(part);
    publish_directory(part.store(), output, part.retired());
  } catch (const Error& error) {
    if (error.code() != ErrorCode::Cancelled) part.remove();
    throw;
  } catch (const fs::filesystem_error& error) {
    part.remove();
    throw Error(ErrorCode::Io, fmt::format("{}: {}", output.string(), error.code().message()));
  } catch (...) {
    part.remove();
    throw;
  }
  part.remove();
}

std::string part_key(const std::string& what, const std::string& source) {
  return fmt::format("{} {} {}\n", kFormatVersion, what, hash128(source).hex());
}

}  // namespace

void build(HeightSource& source, const BuildOptions& options, const BuildContext& context) {
  check_source(source);
  if (fs::exists(options.output) && !options.force) {
    require_same_heights(source, options.output);
    return extend(options.output, options, context);
  }
  in_part_directory(options.output, part_key("build", options.source_key),
                    [&](PartDirectory& part) {
                      StoreBuilder builder(part.units(), part.store(), context);
                      make_store(source, options, builder);
                    });
}

void extend(const fs::path& store, const BuildOptions& options, const BuildContext& context) {
  const Manifest old = open_quietly(store)->manifest();
  in_part_directory(store, part_key("extend", old.id), [&](PartDirectory& part) {
    StoreBuilder builder(part.units(), part.store(), context);
    builder.adopt(store, old);
    if (options.drape != nullptr) write_drape(*options.drape, builder);
    const Terrain& terrain = builder.open_terrain();
    if (options.preprocess) options.preprocess(terrain, builder);
    for (const std::string& method : options.methods)
      if (std::ranges::find(builder.manifest.methods, method) == builder.manifest.methods.end())
        builder.manifest.methods.push_back(method);
    builder.finish();
  });
}

}  // namespace arete::store
