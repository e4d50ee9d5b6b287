#pragma once

#include <tenon/apps/common/outputs.h>

namespace tenon::apps {

/// Sets the figures of a run in real time: ticks that were missed, lateness of ticks at their begin and their
/// times of computing, as quantiles and histograms.
void SetRealTime(const RealTimeStatistics& statistics, Summary& summary);
/// Sets quantiles and histogram of times [s].
void SetTimes(const std::string& name, const TimeQuantiles& times, Summary& summary);

/// Examines this machine, and measures the lateness of ticks at 500 Hz and 1 kHz, for `duration` [s] each.
/// Returns the results, with what to change, and whether everything is permitted and no tick was missed.
std::pair<std::string, bool> ExamineRealTime(double duration);

}  // namespace tenon::apps
