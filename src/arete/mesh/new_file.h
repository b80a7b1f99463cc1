#pragma once

#include <filesystem>
#include <fstream>
#include <span>
#include <string_view>

namespace arete::mesh {

/// A file that appears whole or not at all: written beside its place and renamed.
class NewFile {
 public:
  /// Throws: Io.
  explicit NewFile(std::filesystem::path place);
  ~NewFile();  ///< an unfinished file is removed
  NewFile(const NewFile&) = delete;
  NewFile& operator=(const NewFile&) = delete;

  void write(std::string_view text) {
    out_.write(text.data(), static_cast<std::streamsize>(text.size()));
  }
  template <typename T>
  void write(std::span<const T> values) {
    write(std::string_view(reinterpret_cast<const char*>(values.data()), values.size_bytes()));
  }
  /// Throws: Io.
  void publish();

 private:
  std::filesystem::path place_, part_;
  std::ofstream out_;
};

}  // namespace arete::mesh
