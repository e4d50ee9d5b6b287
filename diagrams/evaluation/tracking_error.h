#pragma once

#include <tenon/controllers/legged/whole_body/whole_body_controller.h>

namespace tenon {

struct TrackingErrorParams {
  QuadrupedDescription robot;        ///< true model of the robot
  double min_singular_value = 0.02;  ///< least singular value of a leg's Jacobian, see SolveFootForces [m]
};

struct WalkingErrors {
  Vec<3> com = Vec<3>::Zero();           ///< x - x_ref of the centre of mass [m]
  Vec<4> foot = Vec<4>::Zero();          ///< |p - p_ref| of each foot in swing, 0 in stance [m]
  Vec<4> ground_force = Vec<4>::Zero();  ///< |planned - true force| of each foot in stance, 0 in swing [N]
  Vec<3> com_position = Vec<3>::Zero();  ///< x of the centre of mass [m]

  static FieldList Fields() {
    return {{"com", &WalkingErrors::com, "m"},
            {"foot", &WalkingErrors::foot, "m", kLegElements},
            {"ground_force", &WalkingErrors::ground_force, "N", kLegElements},
            {"com_position", &WalkingErrors::com_position, "m"}};
  }
};

/// Errors of the motion relative to its plan, without the drift of the state estimate in position and
/// heading, which no sensor of the robot can measure. The plan starts from the estimated pose. With true and
/// estimated position p, p^ and heading psi, psi^ of the trunk, a point x of the robot is transformed to
///
///     x^ = p^ + Rz(psi^ - psi) (x - p)
///
/// before it is compared with the plan. Errors of the estimated roll and pitch are included.
struct PathErrors {
  Vec<3> com = Vec<3>::Zero();    ///< x^ - x_ref of the centre of mass [m]
  Vec<4> foot = Vec<4>::Zero();   ///< |x^ - p_ref| of each foot in swing, 0 in stance [m]
  Vec<3> drift = Vec<3>::Zero();  ///< p^ - p [m]
  double yaw_drift = 0;           ///< psi^ - psi, from -pi to pi [rad]

  static FieldList Fields() {
    return {{"com", &PathErrors::com, "m"},
            {"foot", &PathErrors::foot, "m", kLegElements},
            {"drift", &PathErrors::drift, "m"},
            {"yaw_drift", &PathErrors::yaw_drift, "rad"}};
  }
};

/// Deviations of a walking robot from the plan of its controller. They are figures of merit and must not be
/// fed back, because they are computed from the true state and masses. `path` has the errors without the
/// drift of `told`, the state that the controller reads, and `external_foot_forces` are the forces at the
/// feet that are equivalent to the joint torques of the disturbances, see SolveFootForces.
class TrackingError final : public LeafSystem<TrackingErrorParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPort<LeggedState> state{this, {"state"}};
  InputPort<LeggedState> told{this, {"told"}};
  InputPort<FootForces> foot_forces{this, {"foot_forces"}};
  InputPort<ContactSchedule> schedule{this, {"schedule"}};
  InputPort<BodyReference> body{this, {"body"}};
  InputPort<FeetReference> feet{this, {"feet"}};
  InputPort<WholeBodyPlan> plan{this, {"plan"}};
  InputPort<Vec<12>> external_torque{this, {"external_torque", "N m"}, Vec<12>(Vec<12>::Zero())};
  Parameter<double> min_singular_value{
      this,
      {"min_singular_value", "m"},
      params.min_singular_value,
      "threshold of a leg's Jacobian below which its foot force is damped",
      Range().Positive().Because("it bounds the inverse of a straight leg's Jacobian")};

 private:
  Shared<QuadrupedDynamics> dynamics_{this, "dynamics", Uses(state), QuadrupedModel(params.robot)};

 public:
  OutputPort<WalkingErrors> errors{
      this, {"errors"}, Uses(dynamics_, foot_forces, schedule, body, feet, plan), &TrackingError::CalcErrors};
  OutputPort<PathErrors> path{
      this, {"path"}, Uses(dynamics_, state, told, schedule, body, feet), &TrackingError::CalcPath};
  OutputPort<FootForces> external_foot_forces{this,
                                              {"external_foot_forces"},
                                              Uses(dynamics_, external_torque, min_singular_value),
                                              &TrackingError::CalcExternalFootForces};

 private:
  WalkingErrors CalcErrors(const QuadrupedDynamics& dynamics, const FootForces& foot_forces,
                           const ContactSchedule& schedule, const BodyReference& body,
                           const FeetReference& feet, const WholeBodyPlan& plan) const;
  PathErrors CalcPath(const QuadrupedDynamics& dynamics, const LeggedState& state, const LeggedState& told,
                      const ContactSchedule& schedule, const BodyReference& body,
                      const FeetReference& feet) const;
  FootForces CalcExternalFootForces(const QuadrupedDynamics& dynamics, const Vec<12>& external_torque,
                                    double min_singular_value) const;
};

}  // namespace tenon

TENON_DECLARE_SIGNAL(tenon::WalkingErrors);
TENON_DECLARE_SIGNAL(tenon::PathErrors);
