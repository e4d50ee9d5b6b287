#pragma once

#include <tenon/controllers/legged/planning/map_footholds.h>

namespace tenon {

/// Reflex of a swing foot that hits the side of an obstacle, see SwingPlanner.
struct StepReflex {
  bool enabled = true;      ///< whether the reflex acts
  double lag = 0.03;        ///< horizontal tracking error above which the reflex triggers [m]
  double force = 0.05;      ///< force against the motion above which the reflex triggers, over the weight m g
  double retreat = 0.02;    ///< distance by which the foot moves back before it lands [m]
  double height = 0.1;      ///< lower bound of the next step's height [m]
  double rise_phase = 0.3;  ///< fraction of the next step in which the foot moves straight up

  static FieldList Fields() {
    return {{"enabled", &StepReflex::enabled},
            Field("lag_m", &StepReflex::lag).Positive(),
            Field("force_mg", &StepReflex::force).AtLeast(0),
            Field("retreat_m", &StepReflex::retreat).AtLeast(0),
            Field("height_m", &StepReflex::height).Positive(),
            Field("rise_phase", &StepReflex::rise_phase)
                .Between(0, 0.4)
                .Because("the foot moves ahead in the rest")};
  }
};

/// Shape of the steps and choice of the footholds.
struct StepProperties {
  double height = 0.05;             ///< height of the feet above the higher of lift-off and foothold [m]
  double touchdown_speed = 0.5;     ///< planned downward speed of the foot at touchdown [m/s]
  double search_depth = 0.2;        ///< largest depth of a searching foot below its foothold [m]
  double velocity_feedback = 0.03;  ///< displacement of the foothold per CoM velocity error [s]
  double retarget_phase = 0.7;      ///< swing phase up to which the foothold is updated at every tick
  bool wrench_shift = true;         ///< whether the estimated wrench shifts the footholds
  double free_shift = 0.08;         ///< dead band of the foothold shift [m]
  double shift_bandwidth = 16;      ///< cut-off frequency of the foothold shift [rad/s]
  double free_offset = 0.03;        ///< dead band of the CoM error that moves the footholds [m]
  double free_turn = 0.1;           ///< dead band of the heading error that moves the footholds [rad]
  double largest_shift = 0.1;       ///< saturation of the foothold shift [m]
  StepReflex reflex = {};
  MapFootholdProperties footing = {};  ///< choice of the footholds on an elevation map

  static FieldList Fields() {
    using P = StepProperties;
    return {Field("height_m", &P::height).Positive(),
            Field("touchdown_speed_m_per_s", &P::touchdown_speed)
                .Positive()
                .Because("a late foot must reach the ground"),
            Field("search_depth_m", &P::search_depth).Positive(),
            Field("velocity_feedback_s", &P::velocity_feedback).AtLeast(0),
            Field("retarget_phase", &P::retarget_phase).AtLeast(0).Below(1).Because("at 1 the swing ends"),
            {"wrench_shift", &P::wrench_shift},
            Field("free_shift_m", &P::free_shift).AtLeast(0).OrInfinite(),
            Field("shift_bandwidth_rad_per_s", &P::shift_bandwidth).Positive(),
            Field("largest_shift_m", &P::largest_shift).AtLeast(0).OrInfinite(),
            Field("free_offset_m", &P::free_offset).AtLeast(0).OrInfinite(),
            Field("free_turn_rad", &P::free_turn).AtLeast(0).OrInfinite(),
            {"reflex", &P::reflex},
            {"footing", &P::footing}};
  }
};

}  // namespace tenon
