#pragma once

#include <filesystem>

namespace arete::store {

/// Puts the finished directory `from` at `output` in one step and makes that durable. An old store
/// there changes places with it where the file system can, else is moved to `retired` first.
/// Throws: Io; the old store is at `output` then, or still at `retired` if it cannot go back.
void publish_directory(const std::filesystem::path& from, const std::filesystem::path& output,
                       const std::filesystem::path& retired);

}  // namespace arete::store
