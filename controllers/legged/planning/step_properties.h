#pragma once

#include <tenon/systems/framework/types/fields.h>

namespace tenon {

/// What a foot does that meets the side of something in its swing, see SwingPlanner.
struct StepReflex {
  bool enabled = true;      ///< a foot that meets the side of something gives its step up
  double lag = 0.03;        ///< a foot that is farther off its course has met something, [m]
  double force = 0.05;      ///< if it is pushed back by more, over the robot's weight m g
  double retreat = 0.02;    ///< how far it goes back before it lands [m]
  double height = 0.1;      ///< of its next step, at least [m]
  double rise_phase = 0.3;  ///< part of that step in which it only rises

  static FieldList Fields() {
    return {{"enabled", &StepReflex::enabled}, {"lag_m", &StepReflex::lag},
            {"force_mg", &StepReflex::force},  {"retreat_m", &StepReflex::retreat},
            {"height_m", &StepReflex::height}, {"rise_phase", &StepReflex::rise_phase}};
  }
  void Validate() const;  ///< throws ParameterError
};

/// What a user chooses of the steps.
struct StepProperties {
  double height = 0.05;             ///< of the feet over the higher of take-off and foothold [m]
  double touchdown_speed = 0.5;     ///< downwards, planned; a late foot gets 9 cm deeper in 0.25 s [m/s]
  double search_depth = 0.2;        ///< how far below its foothold a foot searches at most [m]
  double velocity_feedback = 0.03;  ///< of the foothold, per CoM velocity error [s]
  double retarget_phase = 0.7;      ///< part of the swing in which the foothold is chosen anew at every tick
  bool wrench_shift = true;         ///< moves the footholds against the estimated wrench
  double free_shift = 0.08;         ///< what calls for less than this moves nothing [m]
  double shift_bandwidth = 16;      ///< of its low-pass filter [rad/s]
  double free_offset = 0.03;        ///< a CoM that is farther off takes its feet along [m]
  double free_turn = 0.1;           ///< and so does a trunk that is turned more [rad]
  double largest_shift = 0.1;       ///< of a foothold by the wrench, at most [m]
  StepReflex reflex = {};

  static FieldList Fields() {
    return {{"height_m", &StepProperties::height},
            {"touchdown_speed_m_per_s", &StepProperties::touchdown_speed},
            {"search_depth_m", &StepProperties::search_depth},
            {"velocity_feedback_s", &StepProperties::velocity_feedback},
            {"retarget_phase", &StepProperties::retarget_phase},
            {"wrench_shift", &StepProperties::wrench_shift},
            {"free_shift_m", &StepProperties::free_shift},
            {"shift_bandwidth_rad_per_s", &StepProperties::shift_bandwidth},
            {"largest_shift_m", &StepProperties::largest_shift},
            {"free_offset_m", &StepProperties::free_offset},
            {"free_turn_rad", &StepProperties::free_turn},
            {"reflex", &StepProperties::reflex}};
  }
  void Validate() const;  ///< throws ParameterError
};

}  // namespace tenon
