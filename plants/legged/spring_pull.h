#pragma once

#include <tenon/plants/model/quadruped_description.h>
#include <tenon/plants/signals/legged_signals.h>
#include <tenon/systems/framework/block/parameter.h>
#include <tenon/systems/framework/block/ports.h>
#include <tenon/systems/framework/block/system.h>

namespace tenon {

struct SpringPullParams {
  QuadrupedDescription robot;
  double stiffness = 0;  ///< k; 0: as much as half the robot's weight for 0.25 m [N/m]
  double damping = 0;    ///< d; 0: a fifth of what is critical for the whole robot [N s/m]
  double max_force = 0;  ///< 0: the robot's weight [N]

  void Validate() const;  ///< throws ParameterError
};

/// Where a SpringPull holds a robot, and where it pulls.
struct SpringGrip {
  bool on = false;
  int body = 0;                      ///< 0 the trunk, 1 + j the body that joint j moves
  Vec<3> p_B = Vec<3>::Zero();       ///< the point, in that body's frame [m]
  Vec<3> target_W = Vec<3>::Zero();  ///< [m]

  static FieldList Fields() {
    return {{"on", &SpringGrip::on},
            {"body", &SpringGrip::body},
            {"p_B", &SpringGrip::p_B, "m"},
            {"target_W", &SpringGrip::target_W, "m"}};
  }
};

/// A point of a quadruped's body, in W.
struct BodyPoint {
  Vec<3> p_W = Vec<3>::Zero();  ///< [m]
  Vec<3> v_W = Vec<3>::Zero();  ///< [m/s]
};
/// Where a point of a body is and how it moves, by the chain of the joints from the trunk:
/// w_J = w_P + qd R_WJ axis, v_J = v_P + w_P x (p_J - p_P).
BodyPoint PointOfBody(const QuadrupedDescription& robot, const LeggedState& x, int body, const Vec<3>& p_B);
/// The inverse for the place: a point in W, in the frame of the body.
Vec<3> PointInBody(const QuadrupedDescription& robot, const LeggedState& x, int body, const Vec<3>& p_W);

/// A hand that pulls at a point p of a quadruped, by a spring and a damper, no stronger than F_max:
///
///     F = k (target - p) - d v,   |F| <= F_max,
///
/// v being the point's velocity in W. Without `on` there is no force.
///
///     port in     state
///     port out    force
///     parameters  grip
class SpringPull final : public LeafSystem<SpringPullParams> {
 public:
  explicit SpringPull(const SpringPullParams& params) : LeafSystem(Complete(params)) {}

  InputPort<LeggedState> state{this, {"state"}};
  Parameter<SpringGrip> grip{this, {"grip"}, SpringGrip{}, "what is held, and where it is pulled"};
  OutputPort<ExternalForce> force{this, {"force"}, Uses(state, grip), &SpringPull::CalcForce};

 private:
  static SpringPullParams Complete(SpringPullParams params);
  ExternalForce CalcForce(const LeggedState& state, const SpringGrip& grip) const;
};

}  // namespace tenon

TENON_DECLARE_SIGNAL(tenon::SpringGrip);
