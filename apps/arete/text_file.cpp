#include "text_file.h"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <system_error>

#include <fmt/format.h>

#include "arete/core/error.h"

#include "unfinished.h"

namespace arete::app {

void write_text(const std::filesystem::path& file, std::string_view text) {
  std::filesystem::path part = file;
  part += ".part";
  Unfinished unfinished;
  unfinished.add(part);
  std::error_code error;
  std::ofstream out(part, std::ios::binary);
  out << text;
  out.close();
  if (out) {
    std::filesystem::rename(part, file, error);
  } else {
    error.assign(errno, std::generic_category());
  }
  if (error) {
    throw Error(ErrorCode::Io, fmt::format("{}: cannot be written: {}: check the directory",
                                           file.string(), error.message()));
  }
  unfinished.finish();
}

}  // namespace arete::app
