#include <tenon/systems/campaign/campaign.h>

#include <fmt/core.h>

#include <atomic>
#include <mutex>
#include <thread>

namespace tenon {

void ForEachRun(std::size_t count, int jobs, const std::function<void(std::size_t)>& work) {
  if (jobs < 1)
    throw ParameterError(fmt::format("jobs = {} must be positive: set the number of parallel runs", jobs));
  std::atomic<std::size_t> next = 0;
  std::atomic<bool> failed = false;
  std::mutex mutex;
  std::exception_ptr failure;
  const auto take = [&] {
    for (std::size_t k; !failed && (k = next++) < count;) {
      try {
        work(k);
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (!failure) failure = std::current_exception();
        failed = true;
      }
    }
  };
  {
    std::vector<std::jthread> others;
    const std::size_t wanted = std::min(static_cast<std::size_t>(jobs), count);
    for (std::size_t i = 1; i < wanted; ++i) others.emplace_back(take);
    take();
  }
  if (failure) std::rethrow_exception(failure);
}

}  // namespace tenon
