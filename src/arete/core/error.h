#pragma once

#include <stdexcept>
#include <string>

namespace arete {

/// What kind of failure ended an operation. Codes are stable; texts are for people.
enum class ErrorCode {
  Usage,         ///< the caller asked for something that does not exist
  NotFound,      ///< a file or segment is absent
  Unsupported,   ///< a format, driver or feature that this build does not read
  InvalidInput,  ///< a DEM or image that cannot be a terrain
  Corrupt,       ///< a store whose bytes are not those that were written
  Io,            ///< the operating system refused
  Limit,         ///< a budget or a fixed limit would be broken
  Cancelled,     ///< the caller's progress callback said stop
};

/// The one exception of the library. The text reads "FILE: what: what to do".
/// Thrown by opening, building, importing and decoding; never by Engine::refine or draw.
class Error : public std::runtime_error {
 public:
  Error(ErrorCode code, const std::string& text) : std::runtime_error(text), code_(code) {}
  ErrorCode code() const { return code_; }

 private:
  ErrorCode code_;
};

}  // namespace arete
