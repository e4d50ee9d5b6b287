#pragma once

#include <tenon/systems/framework/types/fields.h>

namespace tenon::apps {

/// Delay from the controller to the drives by computation and field bus, see JitteredDelay.
struct LinkScenario {
  double delay_s = 0;   ///< mean delay
  double jitter_s = 0;  ///< delays are uniformly distributed within delay ± jitter

  static FieldList Fields() {
    return {Field("delay_s", &LinkScenario::delay_s).Between(0, 1),
            Field("jitter_s", &LinkScenario::jitter_s).AtLeast(0)};
  }
  void Validate() const;  ///< throws ParameterError
};

}  // namespace tenon::apps
