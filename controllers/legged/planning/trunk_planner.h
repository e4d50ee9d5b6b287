#pragma once

#include <tenon/controllers/legged/planning/nominal_stance.h>
#include <tenon/plants/signals/disturbance_signals.h>
#include <tenon/plants/signals/gait_signals.h>
#include <tenon/plants/signals/motion_signals.h>
#include <tenon/systems/block.h>

namespace tenon {

struct TrunkPlannerParams {
  QuadrupedDescription robot;
  double bandwidth = 20;   ///< cut-off frequency of the low-pass filter of the wrench [rad/s]
  double sway_limit = 80;  ///< limit of the angular acceleration in stance; 0 keeps the trunk level [rad/s^2]
  Rate rate = Hz(1000);
};

/// Plans a sway of the trunk under a steady push that two stance feet cannot resist.
///
/// Two feet exert no moment about the line between them. The component of the external wrench (f, t) on the
/// CoM c about this line, with a point p and direction n, therefore rotates the robot, with inertia I about
/// c, by
///
///     a = n . (t - (p - c) x f) / (n . I n) n,
///
/// with the horizontal part of f: the CoM crosses the line in the middle of the swing, so weight and vertical
/// loads have no mean moment. (Shifted footholds of SwingPlanner balance a part of the push, which is not
/// subtracted here.) f and t are low-pass filtered to remove oscillations within a step.
///
/// A trunk that starts the swing level and at rest is tilted and rotating at its end. This planner starts the
/// swing with half of that rate in the opposite direction: at time s in a swing of duration T,
///
///     angle -s (T - s) a / 2,   rate (s - T / 2) a,   acceleration a,
///
/// so that the trunk is level at both ends, with rates -a T / 2 and a T / 2, its largest tilt is a T^2 / 8
/// instead of a T^2 / 2, and the planned moment is realisable. In the stance of all feet, with duration S, a
/// cubic connects the rate at the last touchdown with that of the next lift-off, which returns the angular
/// momentum of the push in the swing. Its acceleration is limited, and a with it: a T / 2 <= sway_limit S /
/// 6, so a gait without such stances has no sway. While the gait clock waits, angle and rate are constant.
/// There is no sway without a push, while standing, and in swings with more or fewer than two stance feet.
///
/// The sway is a rotation in W composed with the attitude of `body`, small in angle, and is added to its
/// rates. All other entries of `body` are passed on.
class TrunkPlanner final : public LeafSystem<TrunkPlannerParams> {
 public:
  using LeafSystem::LeafSystem;
  const NominalStance stance{params.robot};

  /// Memory of the planner.
  struct Memory {
    WrenchEstimate push;           ///< low-pass filtered wrench
    Vec<3> rate = Vec<3>::Zero();  ///< rate of the sway at the last touchdown [rad/s]

    static FieldList Fields() { return {{"push", &Memory::push}, {"rate", &Memory::rate, "rad/s"}}; }
  };

  InputPort<BodyReference> body{this, {"body"}};
  InputPort<ContactSchedule> schedule{this, {"schedule"}};
  InputPort<LeggedState> state{this, {"state"}};
  InputPort<WrenchEstimate> wrench{this, {"wrench"}, WrenchEstimate()};
  Parameter<double> bandwidth{this,
                              {"bandwidth", "rad/s"},
                              params.bandwidth,
                              "cut-off frequency of the low-pass filter of the wrench",
                              Range().Positive()};
  Parameter<double> sway_limit{this,
                               {"sway_limit", "rad/s^2"},
                               params.sway_limit,
                               "limit of the angular acceleration in stance",
                               Range().AtLeast(0).Because("0 keeps the trunk level")};
  Scratch<Memory> memory{this, "memory", Memory()};
  OutputPort<BodyReference> reference{this,
                                      {"reference"},
                                      Sampled{params.rate},
                                      Uses(body, schedule, state, wrench, bandwidth, sway_limit, memory),
                                      &TrunkPlanner::CalcReference};

 private:
  BodyReference CalcReference(const BodyReference& body, const ContactSchedule& schedule,
                              const LeggedState& state, const WrenchEstimate& wrench, double bandwidth,
                              double sway_limit, Memory& memory) const;
  Vec<3> FreeAcceleration(const ContactSchedule& schedule, const LeggedState& state,
                          const WrenchEstimate& wrench) const;
};

}  // namespace tenon
