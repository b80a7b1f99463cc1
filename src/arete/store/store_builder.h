#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "arete/core/build_context.h"
#include "arete/store/build.h"
#include "arete/store/part_directory.h"
#include "arete/store/segment_reader.h"
#include "arete/store/unit.h"

namespace arete::store {

/// A store that is not yet published: makes segments from units in a part directory.
class StoreBuilder : public Writers {
 public:
  StoreBuilder(const PartDirectory& part, const BuildContext& context);

  Manifest manifest;

  /// Takes over all segments of a published store, as links to the same files.
  void adopt(const std::filesystem::path& store, const Manifest& published);
  /// A segment that a killed build has finished, every page verified; else nothing.
  std::unique_ptr<SegmentReader> find_finished(const std::string& name) const;
  /// Units of a segment whose bytes `content` decides.
  UnitFolder units(const std::string& name, const std::string& content) const;
  /// Joins units into the segment and records it.
  void assemble(const std::string& name, const std::string& params,
                const std::vector<UnitRef>& units);
  /// Joins units 0 .. count-1 of the folder and deletes them.
  void assemble_all(const UnitFolder& folder, int count, const std::string& name,
                    const std::string& params);
  void record(const SegmentReader& finished);
  std::unique_ptr<SegmentReader> open_segment(const std::string& name) const;

  /// Opens the unpublished store; needs heights. write() may be called after it.
  const Terrain& open_terrain();
  void write(const SegmentPlan& plan) override;
  /// Writes the manifest and puts everything on disk.
  void finish();

  const BuildContext& context() const { return context_; }

 private:
  std::filesystem::path file_of(const std::string& name) const;
  void add(const SegmentRecord& record);
  void remove_strays() const;

  std::filesystem::path units_, store_, output_;
  const BuildContext& context_;
  std::unique_ptr<Terrain> terrain_;
};

}  // namespace arete::store
