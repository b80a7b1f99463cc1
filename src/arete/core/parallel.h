#pragma once

#include <functional>

namespace arete {

/// Calls body(i) for every i in [0, count), on up to `threads` threads (the caller's included),
/// in no particular order. Returns when all are done. The first exception stops the handing out of
/// further items and is thrown on to the caller. threads <= 1 runs in order on the caller's thread.
void parallel_for(int threads, int count, const std::function<void(int)>& body);

/// Threads to use when the caller does not say: the machine's, at least 1.
int default_threads();

}  // namespace arete
