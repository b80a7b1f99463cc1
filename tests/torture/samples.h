#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>

#include "arete/store/build.h"

#include "torture/recorder.h"

namespace arete::torture {

/// Builds a small terrain with holes, for every method. Other seeds give other heights.
void build_sample(const std::filesystem::path& output, std::uint32_t seed);
/// The files of a built sample.
Files sample_store(std::uint32_t seed);
/// Adds one segment to a sample, as methods chosen later do.
void extend_sample(const std::filesystem::path& store);

/// Opens a store whose files lie in memory; nothing may change them meanwhile.
/// Throws: as Terrain::open.
std::unique_ptr<store::Terrain> open_in_memory(const Files& files);

/// Everything that can be read out of a store: hashes of decoded blocks, texels and rows by name.
/// What is damaged is absent.
using Content = std::map<std::string, std::uint64_t>;
/// Blocks and texels of one segment only.
Content read_segment(const store::Terrain& terrain, const std::string& segment);
/// All segments, the manifest, rows of heights, rasters made from heights, and what each method
/// draws of a view.
Content read_everything(const store::Terrain& terrain);

enum class Harm { None, Detected, Silent };
/// Silent when some part reads differently from the intact store's although nothing was reported.
Harm compare(const Content& got, const Content& intact, const store::Terrain& terrain);

}  // namespace arete::torture
