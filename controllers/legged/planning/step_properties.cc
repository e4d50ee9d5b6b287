#include <tenon/controllers/legged/planning/step_properties.h>
#include <tenon/systems/framework/block/system.h>

#include <fmt/core.h>

#include <cmath>

namespace tenon {

void StepReflex::Validate() const {
  Demand(lag > 0, fmt::format("lag_m is {} m: it must be positive", lag));
  Demand(force >= 0, fmt::format("force_mg is {}: it must not be negative", force));
  Demand(retreat >= 0, fmt::format("retreat_m is {} m: it must not be negative", retreat));
  Demand(height > 0, fmt::format("height_m is {} m: it must be positive", height));
  Demand(rise_phase >= 0 && rise_phase <= 0.5,
         fmt::format("rise_phase is {}, but must be from 0 to 0.5, where the foot is highest", rise_phase));
}

void StepProperties::Validate() const {
  Demand(height > 0, fmt::format("height_m = {} must be positive", height));
  Demand(std::isfinite(touchdown_speed) && touchdown_speed > 0,
         fmt::format("touchdown_speed_m_per_s = {} must be finite and positive, or a late foot does not "
                     "reach the ground",
                     touchdown_speed));
  Demand(search_depth > 0, fmt::format("search_depth_m = {} must be positive", search_depth));
  Demand(velocity_feedback >= 0,
         fmt::format("velocity_feedback_s = {} must not be negative", velocity_feedback));
  Demand(retarget_phase >= 0 && retarget_phase < 1,
         fmt::format("retarget_phase = {} must be at least 0 and below 1, the end of the swing",
                     retarget_phase));
  Demand(shift_bandwidth > 0,
         fmt::format("shift_bandwidth_rad_per_s = {} must be positive", shift_bandwidth));
  Demand(free_shift >= 0, fmt::format("free_shift_m = {} must not be negative", free_shift));
  Demand(free_offset >= 0, fmt::format("free_offset_m = {} must not be negative", free_offset));
  Demand(free_turn >= 0, fmt::format("free_turn_rad = {} must not be negative", free_turn));
  Demand(largest_shift >= 0, fmt::format("largest_shift_m = {} must not be negative", largest_shift));
  reflex.Validate();
}

}  // namespace tenon
