#include "arete/mesh/new_file.h"

#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "arete/core/error.h"

namespace arete::mesh {

NewFile::NewFile(std::filesystem::path place) : place_(std::move(place)), part_(place_) {
  part_ += ".part";
  out_.open(part_, std::ios::binary | std::ios::trunc);
  if (!out_) {
    throw Error(ErrorCode::Io,
                fmt::format("{}: cannot be created: name a directory that exists and is yours",
                            place_.string()));
  }
}

NewFile::~NewFile() {
  if (!out_.is_open()) return;
  out_.close();
  std::error_code ignored;
  std::filesystem::remove(part_, ignored);
}

void NewFile::publish() {
  out_.flush();
  std::error_code failure;
  if (out_) std::filesystem::rename(part_, place_, failure);
  if (!out_ || failure) {
    throw Error(ErrorCode::Io,
                fmt::format("{}: could not be written: free some space", place_.string()));
  }
  out_.close();
}

}  // namespace arete::mesh
