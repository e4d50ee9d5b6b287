#pragma once

#include <tenon/systems/framework/types/fields.h>

namespace tenon::apps {

/// From the controller to the drives: computing and field bus, see JitteredDelay.
struct LinkScenario {
  double delay_s = 0;
  double jitter_s = 0;  ///< delays lie evenly within delay ± jitter

  static FieldList Fields() {
    return {{"delay_s", &LinkScenario::delay_s}, {"jitter_s", &LinkScenario::jitter_s}};
  }
  void Validate() const;  ///< throws ParameterError
};

}  // namespace tenon::apps
