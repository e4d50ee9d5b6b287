#pragma once

#include <tenon/apps/common/columns.h>
#include <tenon/apps/common/outputs.h>

namespace tenon::apps {

/// Sets the figures of a run in real time: ticks that were missed, lateness of ticks at their begin and their
/// times of computing, as quantiles and histograms.
void SetRealTime(const RealTimeStatistics& statistics, Summary& summary);
/// Sets quantiles and histogram of times [s].
void SetTimes(const std::string& name, const TimeQuantiles& times, Summary& summary);

/// Wall-clock times of a solver and a count of its solves, such as of those that failed, from a log of its
/// `diagnostics`. There are none if a block without this port replaced the controller.
class SolveFigures {
 public:
  template <class Diagnostics>
  void Begin(const std::vector<std::string>& names, const OutputPort<Diagnostics>* diagnostics,
             long Diagnostics::*count) {
    time_ = Column(names, diagnostics, &Diagnostics::solve_time);
    count_ = Column(names, diagnostics, count);
  }
  void Row(std::span<const double> row) {
    if (!time_) return;
    times_.Add(row[*time_]);
    counted_ = row[*count_];
  }
  /// Sets median and 99 % quantile of the times, and the count at the end under the key `counted`.
  void AddTo(Summary& summary, const std::string& solver, const std::string& counted) const {
    summary.Set(solver + "_time_median_us", Microseconds(times_.Quantile(0.5)));
    summary.Set(solver + "_time_p99_us", Microseconds(times_.Quantile(0.99)));
    summary.Set(counted, counted_);
  }

 private:
  std::optional<std::size_t> time_, count_;  // columns
  TimeQuantiles times_;                      // [s]
  std::optional<double> counted_;
};

/// Examines this machine, and measures the lateness of ticks at 500 Hz and 1 kHz, for `duration` [s] each.
/// Returns the results, with what to change, and whether everything is permitted and no tick was missed.
std::pair<std::string, bool> ExamineRealTime(double duration);

}  // namespace tenon::apps
