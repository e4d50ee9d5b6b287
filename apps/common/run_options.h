#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

namespace tenon::apps {

/// Exit codes of all apps. A run that a signal stops returns 128 plus the number of the signal: 130 after
/// Ctrl-C, 143 after SIGTERM.
enum ExitCode {
  kRan = 0,
  kBadUsage = 2,          ///< command line, scenario or robot file
  kLimitBroken = 3,       ///< the robot fell, broke a forbidden limit, or exceeded physical limits
  kNumericalFailure = 4,  ///< includes lack of memory
  kOutputFailed = 5,      ///< a file could not be written
};

class LiveSession;

/// Options of a run: its output and its time limit.
struct RunOptions {
  std::filesystem::path out;              ///< directory; empty: no files and no progress
  std::string name = {};                  ///< shown with the progress, such as "run 3 of 64"; may be empty
  std::string graph = {};                 ///< file of the diagram's graph; empty: none
  std::optional<double> wall_limit = {};  ///< limit of the wall-clock time [s]
  /// Steers the run by browsers or a recording; may be null.
  std::shared_ptr<LiveSession> live = {};
};

}  // namespace tenon::apps
