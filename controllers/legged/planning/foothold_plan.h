#pragma once

#include <tenon/plants/signals/leg.h>
#include <tenon/systems/framework/types/signal.h>

namespace tenon {

/// Horizontal positions of the footholds at which swinging feet are to land. Without a plan, `planned` is
/// false, and the reader chooses its own.
struct FootholdPlan {
  bool planned = false;
  std::array<Vec<2>, kNumLegs> position_W{};  ///< of the feet's centres [m]

  FootholdPlan() { position_W.fill(Vec<2>::Zero()); }
  static FieldList Fields() {
    return {{"planned", &FootholdPlan::planned},
            {"position_W", &FootholdPlan::position_W, "m", kLegElements}};
  }
};

}  // namespace tenon

TENON_DECLARE_SIGNAL(tenon::FootholdPlan);
