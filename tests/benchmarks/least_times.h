#pragma once

#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <limits>
#include <numeric>
#include <string>
#include <vector>

namespace tenon {

/// Records the least time of each item of a sequence over identical repetitions, so that other load of the
/// machine does not count.
class LeastTimes {
 public:
  explicit LeastTimes(std::size_t items) : ns_(items, std::numeric_limits<double>::infinity()) {}

  /// Returns the result of `f`, whose time counts for this item.
  template <class F>
  auto Measure(std::size_t item, F&& f) {
    const Stopwatch stopwatch(ns_[item]);
    return f();
  }

  /// Sets the counters median_ns, p99_ns and mean_ns over the items, with `prefix` in front.
  void Report(benchmark::State& state, const std::string& prefix = "") {
    std::sort(ns_.begin(), ns_.end());
    state.counters[prefix + "median_ns"] = ns_[ns_.size() / 2];
    state.counters[prefix + "p99_ns"] = ns_[ns_.size() * 99 / 100];
    state.counters[prefix + "mean_ns"] =
        std::accumulate(ns_.begin(), ns_.end(), 0.0) / static_cast<double>(ns_.size());
  }

 private:
  class Stopwatch {
   public:
    explicit Stopwatch(double& least_ns) : least_ns_(least_ns) {}
    Stopwatch(const Stopwatch&) = delete;
    Stopwatch& operator=(const Stopwatch&) = delete;
    ~Stopwatch() {
      const std::chrono::duration<double, std::nano> elapsed = std::chrono::steady_clock::now() - begin_;
      least_ns_ = std::min(least_ns_, elapsed.count());
    }

   private:
    double& least_ns_;
    std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  };

  std::vector<double> ns_;
};

}  // namespace tenon
