#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

namespace tenon::apps {

/// What every app returns to the shell. What a signal stops returns 128 and its number, as in a shell: 130
/// after Ctrl-C, 143 after SIGTERM.
enum ExitCode {
  kRan = 0,
  kBadUsage = 2,          ///< command line, scenario or robot file
  kLimitBroken = 3,       ///< the robot fell, broke a forbidden limit, or did what no robot can
  kNumericalFailure = 4,  ///< or out of memory
  kOutputFailed = 5,      ///< a file could not be written
};

class LiveSession;

/// What a run leaves, and how long it may take.
struct RunOptions {
  std::filesystem::path out;              ///< directory; empty: no file and no progress, figures alone
  std::string name = {};                  ///< where its progress is told: "run 3 of 64"; empty: none
  std::string graph = {};                 ///< file; empty: none
  std::optional<double> wall_limit = {};  ///< [s] on the clock
  /// If there is one: the run is steered by browsers, or by the recording of such a run.
  std::shared_ptr<LiveSession> live = {};
};

}  // namespace tenon::apps
