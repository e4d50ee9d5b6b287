#pragma once

#include <tenon/plants/model/quadruped_description.h>
#include <tenon/plants/signals/legged_signals.h>
#include <tenon/systems/block.h>

namespace tenon {

struct SpringPullParams {
  QuadrupedDescription robot;
  double stiffness = 0;  ///< k; 0: half the robot's weight over 0.25 m [N/m]
  double damping = 0;    ///< d; 0: a fifth of critical damping of the robot's mass [N s/m]
  double max_force = 0;  ///< F_max; 0: the robot's weight [N]

  void Validate() const;  ///< throws ParameterError
};

/// Point of the robot and target of a SpringPull.
struct SpringGrip {
  bool on = false;
  int body = 0;                      ///< 0 the trunk, 1 + j the body that joint j moves
  Vec<3> p_B = Vec<3>::Zero();       ///< point p in that body's frame [m]
  Vec<3> target_W = Vec<3>::Zero();  ///< [m]

  static FieldList Fields() {
    return {{"on", &SpringGrip::on},
            {"body", &SpringGrip::body},
            {"p_B", &SpringGrip::p_B, "m"},
            {"target_W", &SpringGrip::target_W, "m"}};
  }
};

/// Motion of a point of a quadruped in W.
struct BodyPoint {
  Vec<3> p_W = Vec<3>::Zero();  ///< [m]
  Vec<3> v_W = Vec<3>::Zero();  ///< [m/s]
};
/// Motion of a point of a body, by the recursion along the leg's joints:
/// w_J = w_P + qd R_WJ axis, v_J = v_P + w_P x (p_J - p_P).
BodyPoint PointOfBody(const QuadrupedDescription& robot, const LeggedState& x, int body, const Vec<3>& p_B);
/// A position in W expressed in the frame of a body [m].
Vec<3> PointInBody(const QuadrupedDescription& robot, const LeggedState& x, int body, const Vec<3>& p_W);

/// Pulls a point p of a quadruped to a target by a spring and a damper, with a force of at most F_max:
///
///     F = k (target - p) - d v,   |F| <= F_max,
///
/// with the point's velocity v in W. The force is 0 unless `on` is set.
class SpringPull final : public LeafSystem<SpringPullParams> {
 public:
  explicit SpringPull(const SpringPullParams& given) : LeafSystem(Complete(given)) {}

  InputPort<LeggedState> state{this, {"state"}};
  Parameter<SpringGrip> grip{
      this, {"grip"}, SpringGrip{}, "point that is held, and the target it is pulled to"};
  OutputPort<ExternalForce> force{this, {"force"}, Uses(state, grip), &SpringPull::CalcForce};

 private:
  static SpringPullParams Complete(SpringPullParams params);
  ExternalForce CalcForce(const LeggedState& state, const SpringGrip& grip) const;
};

}  // namespace tenon

TENON_DECLARE_SIGNAL(tenon::SpringGrip);
