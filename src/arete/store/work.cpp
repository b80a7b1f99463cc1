#include "arete/store/work.h"

#include <algorithm>
#include <utility>

#include "arete/core/error.h"
#include "arete/core/parallel.h"

namespace arete::store {

StepProgress::StepProgress(const BuildContext& context, std::string step, int total)
    : context_(context), step_(std::move(step)), total_(total) {
  report();
}

void StepProgress::add_one() {
  ++done_;
  if (std::this_thread::get_id() == caller_) report();
}

void StepProgress::report() const {
  const double share = total_ > 0 ? static_cast<double>(done_) / total_ : 1;
  if (context_.progress && !context_.progress(step_, share))
    throw Error(ErrorCode::Cancelled, "build: cancelled: run it again to go on");
}

int threads_within(const BuildContext& context, std::size_t bytes_each) {
  const std::size_t fit = context.memory_limit / 2 / std::max<std::size_t>(bytes_each, 1);
  return std::max(1, static_cast<int>(std::min<std::size_t>(
                         fit, static_cast<std::size_t>(std::max(context.threads, 1)))));
}

void for_each_unit(const BuildContext& context, const std::string& step, int count,
                   std::size_t bytes_each, const std::function<void(int)>& body) {
  StepProgress progress(context, step, count);
  parallel_for(threads_within(context, bytes_each), count, [&](int i) {
    body(i);
    progress.add_one();
  });
}

}  // namespace arete::store
