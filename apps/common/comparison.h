#pragma once

#include <tenon/apps/common/run_scenario.h>

#include <functional>
#include <string>
#include <vector>

namespace tenon::apps {

/// One of several runs, into the directory that its options name.
struct Variant {
  std::string name;
  std::function<RunResult(const RunOptions&)> run;
};

/// Throws ParameterError unless every name is one of a directory, below that of the whole, and of its own.
void CheckVariantNames(const std::vector<std::string>& names);

/// Runs all variants, each into a directory of its name below that of the options; writes one summary.json
/// with the figures of each by name, and one report.html of all, or of the first kReported. `report` has
/// their title and plots. What stops one run, a signal or a full disk, stops all. Returns the worst exit
/// code.
int Compare(const RunOptions& options, Report report, const std::vector<Variant>& variants);
inline constexpr std::size_t kReported = 8;

}  // namespace tenon::apps
