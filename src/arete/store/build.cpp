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

// "NAME.arete/" names the same directory as "NAME.arete", but has no siblings of its own.
fs::path without_slash(const fs::path& path) {
  return path.has_filename() ? path : path.parent_path();
}

// --force replaces a store, never anything else that happens to bear the name.
void require_store(const fs::path& output) {
  if (!fs::exists(output) || fs::exists(output / "manifest.json")) return;
  throw Error(ErrorCode::Usage,
              output.string() + ": exists and is no store: choose another output");
}

// Another build has published between our first look and our lock.
[[noreturn]] void fail_changed(const fs::path& output) {
  throw Error(ErrorCode::Io,
              output.string() + ": another build has just changed it: run the same command again");
}

std::uint64_t valid_posts(const Manifest& m) {
  const double posts = static_cast<double>(m.cols) * m.rows;
  return static_cast<std::uint64_t>(std::llround(posts * (1 - m.nodata_share)));
}

// A store of the same heights may be added to; anything else must be asked for by name. A valid
// post without a drawable cell may not be stored, so valid posts are counted, too.
void require_same_heights(HeightSource& source, const fs::path& store) {
  const auto terrain = open_quietly(store);
  const Manifest& m = terrain->manifest();
  const auto stored = terrain->height_source();
  bool same = m.cols == source.cols() && m.rows == source.rows() &&
              m.georef.world_from_post == source.georef().world_from_post &&
              m.georef.crs_from_post == source.georef().crs_from_post &&
              m.georef.crs == source.georef().crs;
  std::uint64_t valid = 0;
  std::vector<float> was(static_cast<std::size_t>(m.cols));
  std::vector<float> is(was.size());
  for (int r = 0; same && r < m.rows; ++r) {
    stored->read_row(r, was);
    source.read_row(r, is);
    for (std::size_t c = 0; c < was.size(); ++c) {
      valid += std::isnan(is[c]) ? 0 : 1;
      same = same && (std::isnan(was[c]) ||
                      std::abs(static_cast<double>(was[c]) - is[c]) <= m.max_store_error_m);
    }
  }
  same = same && valid == valid_posts(m);
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
    part.forget_key();
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

// Of a store that is where it belongs.
void add_to(const fs::path& store, const BuildOptions& options, const BuildContext& context) {
  const Manifest old = open_quietly(store)->manifest();
  in_part_directory(
      store, part_key("extend", old.id + options.source_key), [&](PartDirectory& part) {
        if (open_quietly(store)->manifest().id != old.id) fail_changed(store);
        StoreBuilder builder(part, context);
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

}  // namespace

void build(HeightSource& source, const BuildOptions& options, const BuildContext& context) {
  check_source(source);
  const fs::path output = without_slash(options.output);
  bring_back_store(output);
  if (fs::exists(output) && !options.force) {
    require_same_heights(source, output);
    return add_to(output, options, context);
  }
  require_store(output);
  const bool replaces = fs::exists(output);
  in_part_directory(output, part_key("build", options.source_key), [&](PartDirectory& part) {
    if (fs::exists(output) != replaces) fail_changed(output);
    StoreBuilder builder(part, context);
    make_store(source, options, builder);
  });
}

void extend(const fs::path& named, const BuildOptions& options, const BuildContext& context) {
  const fs::path store = without_slash(named);
  bring_back_store(store);
  add_to(store, options, context);
}

}  // namespace arete::store
