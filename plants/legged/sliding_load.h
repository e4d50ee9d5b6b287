#pragma once

#include <tenon/plants/model/rigid_inertia.h>
#include <tenon/plants/signals/legged_signals.h>
#include <tenon/systems/block.h>
#include <tenon/systems/geometry.h>

namespace tenon {

/// The defaults model a wooden box on an aluminium plate (dry friction about 0.3), which yields by 2 mm under
/// 5 kg.
struct SlidingLoadParams {
  double mass = 0;                       ///< m; 0: no load until the Parameter is set [kg]
  Vec<3> position_B = Vec<3>::Zero();    ///< initial position of its centre in B [m]
  Vec<2> reach = Vec<2>::Constant(0.1);  ///< distance of the stops from position_B along x and y [m]
  double friction = 0.3;                 ///< mu, friction coefficient between load and trunk
  double slip_speed = 0.01;              ///< v_s [m/s]
  double stiffness = 25e3;               ///< k of trunk and stops [N/m]
  double damping_ratio = 0.5;            ///< damping ratio of the load on this spring
  LeggedState robot = {};                ///< initial state of the robot
  double gravity = kGravity;             ///< [m/s^2]

  static FieldList Fields() {
    using P = SlidingLoadParams;
    return {Undescribed("mass", &P::mass).AtLeast(0),
            Undescribed("position_B", &P::position_B).Finite(),
            Field("reach_m", &P::reach).AtLeast(0),
            Field("friction", &P::friction).Between(0, 10),
            Undescribed("slip_speed", &P::slip_speed).Positive(),
            Undescribed("stiffness", &P::stiffness).Positive(),
            Undescribed("damping_ratio", &P::damping_ratio).AtLeast(0),
            Undescribed(&P::robot),
            Undescribed("gravity", &P::gravity).Positive()};
  }
};

/// Motion of the load in W.
struct LoadMotion {
  Vec<3> p_W = Vec<3>::Zero();  ///< [m]
  Vec<3> v_W = Vec<3>::Zero();  ///< [m/s]

  static FieldList Fields() { return {{"p_W", &LoadMotion::p_W, "m"}, {"v_W", &LoadMotion::v_W, "m/s"}}; }
};

/// A load that slides on a robot's trunk between stops: a point mass m at r in B, with r = position_B at the
/// start and normal force, friction and stop forces from the trunk,
///
///     m v' = m g + f,      f = n N + t T + stops,
///     N = max(0, m g - k z - d z')         along the trunk's z, with z relative to the start
///     T = -mu N s / sqrt(|s|^2 + v_s^2)    with the tangential velocity s: regularised dry friction
///     stops: max(0, k e + d e'), e > 0     excess e over `reach` along x or y
///
/// with d = 2 damping_ratio sqrt(k m). The force -f acts on the trunk at the load, so momentum is conserved.
/// The normal force is unilateral, so the load can be thrown off. With mass 0 there is no force and the load
/// follows position_B, where it starts when its mass is set.
class SlidingLoad final : public LeafSystem<SlidingLoadParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPort<LeggedState> robot{this, {"robot"}};
  Parameter<double> mass{this, {"mass", "kg"}, params.mass, "mass of the load; 0: no load"};
  Parameter<double> friction{this, {"friction"}, params.friction, "friction between trunk and load"};
  Parameter<double> slip_speed{
      this, {"slip_speed", "m/s"}, params.slip_speed, "speed at which friction is 71 % of its bound"};
  ContinuousState<LoadMotion> motion{this, {"motion"}, Start(params)};
  OutputPort<Vec<3>> place{this, {"place", "m"}, Uses(robot, motion), &SlidingLoad::CalcPlace};
  OutputPort<ExternalForce> force{
      this, {"force"}, Uses(robot, motion, place, mass, friction, slip_speed), &SlidingLoad::CalcForce};
  TimeDerivative<LoadMotion> dmotion{motion, Uses(robot, motion, force, mass), &SlidingLoad::CalcDerivative};
  OutputPort<Geometry> geometry{
      this, {"geometry"}, MakeGeometry(), Uses(robot, motion, mass), &SlidingLoad::CalcGeometry};

 private:
  static LoadMotion Start(const SlidingLoadParams& params);
  static Geometry MakeGeometry();
  Vec<3> CalcPlace(const LeggedState& robot, const LoadMotion& motion) const {
    return robot.R_WB().transpose() * (motion.p_W - robot.p_WB);
  }
  ExternalForce CalcForce(const LeggedState& robot, const LoadMotion& motion, const Vec<3>& place,
                          double mass, double friction, double slip_speed) const;
  LoadMotion CalcDerivative(const LeggedState& robot, const LoadMotion& motion, const ExternalForce& force,
                            double mass) const;
  void CalcGeometry(const LeggedState& robot, const LoadMotion& motion, double mass,
                    Geometry* geometry) const;
};

}  // namespace tenon

TENON_DECLARE_SIGNAL(tenon::LoadMotion);
