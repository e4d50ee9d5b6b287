#pragma once

#include <string>
#include <vector>

namespace tenon::apps {

// Remarks on parts of a scenario that have no effect: "forces.0 never acts: duration_s is 0".

/// The interval in which a disturbance acts.
struct Acts {
  double start = 0;    ///< key start_s [s]
  double length = -1;  ///< key duration_s [s]; negative: until the end
};

/// Adds a remark if the disturbance at `key` never acts in a run of `duration` [s]. A nonempty `reason` is an
/// additional reason why it does not act.
void AddIdle(const std::string& key, const Acts& acts, double duration, const std::string& reason,
             std::vector<std::string>& notes);

}  // namespace tenon::apps
