#pragma once

#include <fmt/core.h>

#include <tenon/apps/common/checks.h>
#include <tenon/systems/framework/fields.h>

namespace tenon::apps {

/// From the controller to the drives: computing and field bus, see JitteredDelay.
struct LinkScenario {
  double delay_s = 0;
  double jitter_s = 0;  ///< delays lie evenly within delay ± jitter

  static FieldList Fields() {
    return {{"delay_s", &LinkScenario::delay_s}, {"jitter_s", &LinkScenario::jitter_s}};
  }
  /// Throws ParameterError.
  void Validate() const {
    DemandBetween("delay_s", delay_s, 0, 1);
    Demand(jitter_s >= 0 && jitter_s <= delay_s,
           fmt::format("jitter_s = {} must be from 0 to delay_s = {}: no command arrives before it is sent",
                       jitter_s, delay_s));
  }
};

}  // namespace tenon::apps
