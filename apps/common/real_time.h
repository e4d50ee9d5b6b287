#pragma once

#include <tenon/apps/common/outputs.h>

namespace tenon::apps {

/// Sets the figures of a run in real time: ticks that were missed, lateness of ticks at their begin and their
/// times of computing, as quantiles and histograms.
void SetRealTime(const RealTimeStatistics& statistics, Summary& summary);
/// Sets quantiles and histogram of times [s].
void SetTimes(const std::string& name, const TimeQuantiles& times, Summary& summary);

/// Whether a machine can hold real time.
struct RealTimeReport {
  std::string text;    ///< with what to change
  bool holds = false;  ///< everything is permitted, and no tick was missed
};
/// Examines this machine, and measures the lateness of ticks at 500 Hz and 1 kHz, for `duration` [s] each.
RealTimeReport ExamineRealTime(double duration);

}  // namespace tenon::apps
