#pragma once

#include <cstddef>
#include <functional>
#include <string_view>

#include "arete/core/parallel.h"

namespace arete {

/// What any long operation is given. None of it may change a byte of the result.
struct BuildContext {
  int threads = default_threads();
  std::size_t memory_limit = std::size_t{1} << 30U;  ///< bytes, for buffers and caches together
  /// Called from the thread that started the operation with the step's name and its share done,
  /// 0..1. Return false to cancel (then Error Cancelled). May be empty.
  std::function<bool(std::string_view step, double done)> progress;
};

}  // namespace arete
