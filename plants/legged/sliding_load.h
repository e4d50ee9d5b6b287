#pragma once

#include <tenon/plants/model/gravity.h>
#include <tenon/plants/signals/legged_signals.h>
#include <tenon/systems/framework/block/parameter.h>
#include <tenon/systems/framework/block/ports.h>
#include <tenon/systems/framework/block/state.h>
#include <tenon/systems/framework/block/system.h>
#include <tenon/systems/geometry.h>

namespace tenon {

/// Defaults: a wooden box on an aluminium plate (dry friction about 0.3), which gives way by 2 mm to 5 kg.
struct SlidingLoadParams {
  double mass = 0;                       ///< m; 0: it is not there, until the Parameter is set [kg]
  Vec<3> position_B = Vec<3>::Zero();    ///< of its centre at the start, in the trunk's frame [m]
  Vec<2> reach = Vec<2>::Constant(0.1);  ///< how far it slides from there to either side along x and y [m]
  double friction = 0.3;                 ///< mu
  double slip_speed = 0.01;              ///< v_s [m/s]
  double stiffness = 25e3;               ///< k of trunk and stops [N/m]
  double damping_ratio = 0.5;            ///< of the load on this spring
  LeggedState robot = {};                ///< where the robot starts, and the load with it
  double gravity = kGravity;             ///< [m/s^2]

  void Validate() const;  ///< throws ParameterError
};

/// Where the load is and how it moves, in W.
struct LoadMotion {
  Vec<3> p_W = Vec<3>::Zero();  ///< [m]
  Vec<3> v_W = Vec<3>::Zero();  ///< [m/s]

  static FieldList Fields() { return {{"p_W", &LoadMotion::p_W, "m"}, {"v_W", &LoadMotion::v_W, "m/s"}}; }
};

/// A load that lies on a robot's trunk and slides there, up to stops: a point mass m at r in the trunk's
/// frame, r = position_B at the start, that the trunk presses, rubs and stops,
///
///     m v' = m g + f,      f = n N + t T + stops,
///     N = max(0, m g - k z - d z')         along the trunk's z, that of r beyond the start's
///     T = -mu N s / sqrt(|s|^2 + v_s^2)    along the trunk, s the velocity there: dry friction that creeps
///     stops: max(0, k e + d e'), e > 0     by which it is beyond its reach to a side, back along x or y
///
/// with d = 2 damping_ratio sqrt(k m). The trunk feels -f where the load is, so that momentum is kept.
/// Nothing holds it from above: it can be thrown off. Without mass it is not there, and its motion follows
/// that of position_B: so it lies there when it gets a mass.
///
///     port in     robot
///     ports out   force     on the trunk: -f at r
///                 place     r [m]
///                 geometry  a box of the load's place
///     parameters  mass [kg], friction, slip_speed [m/s]
class SlidingLoad final : public LeafSystem<SlidingLoadParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPort<LeggedState> robot{this, {"robot"}};
  Parameter<double> mass{this, {"mass", "kg"}, params.mass, "of the load; 0: there is none"};
  Parameter<double> friction{this, {"friction"}, params.friction, "between trunk and load"};
  Parameter<double> slip_speed{
      this, {"slip_speed", "m/s"}, params.slip_speed, "at which friction has reached 71 % of its bound"};
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
  Vec<3> CalcPlace(const LeggedState& robot, const LoadMotion& motion) const;
  ExternalForce CalcForce(const LeggedState& robot, const LoadMotion& motion, const Vec<3>& place,
                          double mass, double friction, double slip_speed) const;
  LoadMotion CalcDerivative(const LeggedState& robot, const LoadMotion& motion, const ExternalForce& force,
                            double mass) const;
  void CalcGeometry(const LeggedState& robot, const LoadMotion& motion, double mass,
                    Geometry* geometry) const;
};

}  // namespace tenon

TENON_DECLARE_SIGNAL(tenon::LoadMotion);
