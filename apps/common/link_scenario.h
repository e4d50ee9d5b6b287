#pragma once

#include <tenon/systems/framework/types/fields.h>

namespace tenon::apps {

/// Delay from the controller to the drives by computation and field bus, see JitteredDelay.
struct LinkScenario {
  double delay_s = 0;   ///< mean delay
  double jitter_s = 0;  ///< delays are uniformly distributed within delay ± jitter

  static FieldList Fields() {
    return {{"delay_s", &LinkScenario::delay_s}, {"jitter_s", &LinkScenario::jitter_s}};
  }
  void Validate() const;  ///< throws ParameterError
};

}  // namespace tenon::apps
