#pragma once

#include <string>
#include <vector>

namespace tenon::apps {

// Remarks on what a scenario gives that does nothing in a run: "forces.0 never acts: duration_s is 0".

/// When a disturbance acts.
struct Acts {
  double start = 0;    ///< key start_s [s]
  double length = -1;  ///< key duration_s [s]; negative: to the end
};

/// A remark on the disturbance at `key` if it never acts in a run of `duration` [s]; `reason` is another one
/// why it does not, empty: none.
void AddIdle(const std::string& key, const Acts& acts, double duration, const std::string& reason,
             std::vector<std::string>& notes);

}  // namespace tenon::apps
