#include "unfinished.h"

#include <system_error>

#include <fmt/format.h>

#include "arete/core/error.h"

namespace arete::app {

namespace fs = std::filesystem;

Unfinished::~Unfinished() {
  for (auto path = paths_.rbegin(); path != paths_.rend(); ++path) {
    std::error_code ignored;
    fs::remove(*path, ignored);
  }
}

void Unfinished::add_directory(const fs::path& directory) {
  std::error_code error;
  const bool made = fs::create_directories(directory, error);
  if (error) {
    throw Error(ErrorCode::Io, fmt::format("{}: cannot be made: {}: choose another directory",
                                           directory.string(), error.message()));
  }
  if (made) {
    add(directory);
  } else if (!fs::is_empty(directory)) {
    throw Error(ErrorCode::InvalidInput,
                fmt::format("{}: holds files already: empty it or choose another directory",
                            directory.string()));
  }
}

}  // namespace arete::app
