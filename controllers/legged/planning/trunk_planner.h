#pragma once

#include <tenon/controllers/legged/planning/nominal_stance.h>
#include <tenon/plants/signals/disturbance_signals.h>
#include <tenon/plants/signals/gait_signals.h>
#include <tenon/plants/signals/legged_signals.h>
#include <tenon/plants/signals/motion_signals.h>
#include <tenon/systems/framework/block/parameter.h>
#include <tenon/systems/framework/block/ports.h>
#include <tenon/systems/framework/block/state.h>
#include <tenon/systems/framework/block/system.h>

namespace tenon {

struct TrunkPlannerParams {
  QuadrupedDescription robot;
  double bandwidth = 20;   ///< of the filter through which the wrench goes [rad/s]
  double sway_limit = 80;  ///< of the angular acceleration in stance; 0 keeps the trunk level [rad/s^2]
  Rate rate = Hz(1000);
  void Validate() const;  ///< throws ParameterError
};

/// Lets the trunk sway under a steady push, where two feet cannot hold it.
///
/// Two feet exert no torque about the line between them. Of the wrench (f, t) on the CoM c, which the ground
/// has to balance, the part about this line (p a point of it, n its direction) so turns the robot, with its
/// inertia I about c, by
///
///     a = n . (t - (p - c) x f) / (n . I n) n,
///
/// with the horizontal part of f: the CoM passes the line in the middle of the swing, so that weight and
/// loads have no moment in the mean. (Feet that SwingPlanner has shifted against the push take a part of it,
/// which is not taken off here.) f and t are low-pass filtered: what goes to and fro in a step is no steady
/// push.
///
/// A trunk that begins the swing level and at rest is tilted and turning at its end. This planner begins it
/// with half of the rate the other way: in a swing of the duration T, at the time s,
///
///     angle -s (T - s) a / 2,   rate (s - T / 2) a,   acceleration a,
///
/// so that the trunk is level at both ends, with rates -a T / 2 and a T / 2; tilted by 1/8 a T^2 at most and
/// not by 1/2 a T^2; and the torque that is asked for is the one that there is. In the stance of all feet, S
/// seconds long, a cubic leads from the rate at the last touchdown to that of the coming lift-off: the torque
/// that the push takes in the swing is given back here. Its acceleration, and with it a, is limited:
/// a T / 2 <= sway_limit S / 6, so that a gait without such stances does not sway. While the gait clock
/// waits, angle and rate stay as they are. Where the timetable leaves other than two feet on the ground in a
/// swing, and standing, there is no sway, nor is there without a push.
///
/// The sway is a rotation about axes of W on top of the attitude of `body`, small in angle, and is added to
/// its rates; CoM and the rest are passed on.
///
///     | port      | kind            | type            |
///     | body      | input           | BodyReference   |
///     | schedule  | input           | ContactSchedule |
///     | state     | input           | LeggedState     |
///     | wrench    | input           | WrenchEstimate  |
///     | reference | output, sampled | BodyReference   |
///
/// `bandwidth` and `sway_limit` are Parameters: a run can change them.
class TrunkPlanner final : public LeafSystem<TrunkPlannerParams> {
 public:
  using LeafSystem::LeafSystem;
  const NominalStance stance{params.robot};

  /// What the planner remembers.
  struct Memory {
    WrenchEstimate push;           ///< filtered
    Vec<3> rate = Vec<3>::Zero();  ///< of the sway at the last touchdown [rad/s]

    static FieldList Fields() { return {{"push", &Memory::push}, {"rate", &Memory::rate, "rad/s"}}; }
  };

  InputPort<BodyReference> body{this, {"body"}};
  InputPort<ContactSchedule> schedule{this, {"schedule"}};
  InputPort<LeggedState> state{this, {"state"}};
  InputPort<WrenchEstimate> wrench{this, {"wrench"}, WrenchEstimate()};
  Parameter<double> bandwidth{
      this, {"bandwidth", "rad/s"}, params.bandwidth, "of the filter through which the wrench goes"};
  Parameter<double> sway_limit{
      this, {"sway_limit", "rad/s^2"}, params.sway_limit, "of the angular acceleration in stance"};
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
