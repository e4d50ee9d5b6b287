#pragma once

#include <tenon/apps/common/run_scenario.h>

#include <functional>
#include <string>
#include <vector>

namespace tenon::apps {

/// One of several runs, which writes into the directory that its options name.
struct Variant {
  std::string name;
  std::function<RunResult(const RunOptions&)> run;
};

/// Runs all variants, each into a subdirectory of its name, and writes one summary.json with the figures of
/// each variant and one report.html of the first kReported variants. `report` has their title and plots. A
/// signal or a full disk stops all runs. Returns the largest exit code. Throws ParameterError if two variants
/// have the same name.
int Compare(const RunOptions& options, Report report, const std::vector<Variant>& variants);
inline constexpr std::size_t kReported = 8;

}  // namespace tenon::apps
