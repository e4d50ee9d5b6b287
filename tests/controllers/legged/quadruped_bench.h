#pragma once

#include <tenon/controllers/legged/whole_body/joint_pd.h>
#include <tenon/plants/model/quadruped_model.h>
#include <tenon/plants/signals/imu_signals.h>
#include <tenon/tests/testing/dense_algebra.h>
#include <tenon/tests/testing/test_rig.h>

#include <Eigen/Geometry>

namespace tenon::test {

/// Legs that swing about the nominal stance [rad].
inline std::function<Vec<12>(double)> Swinging(const QuadrupedDescription& robot) {
  return [stance = robot.stance](double t) {
    Vec<12> q = stance;
    for (int j = 0; j < kNumJoints; ++j) q[j] += 0.2 * std::sin(10 * t + j);
    return q;
  };
}

/// A quadruped simulated by its model at 1 kHz with held torques, for observers with the same model. The
/// forces of the ground act at the lowest points of the feet. These and the generalised external forces are
/// functions of state and time.
struct QuadrupedBench {
  using Ground = std::function<FootForces(const LeggedState&, const QuadrupedDynamics&, double t)>;
  using External = std::function<Vec<18>(const LeggedState&, const QuadrupedDynamics&, double t)>;

  explicit QuadrupedBench(const QuadrupedDescription& robot_in) : robot(robot_in), model(robot) {
    x.q = robot.stance;
    joint_reference = [stance = robot.stance](double) { return stance; };
    ground = [](const LeggedState&, const QuadrupedDynamics&, double) { return FootForces(); };
    external = [](const LeggedState&, const QuadrupedDynamics&, double) { return Vec<18>(Vec<18>::Zero()); };
  }

  QuadrupedDescription robot;
  QuadrupedModel model;
  LeggedState x;
  double t = 0;
  std::function<Vec<12>(double)> joint_reference;
  Ground ground;
  External external;

  static constexpr double kPeriod = 1e-3;

  /// Holds the lowest points of the feet in place by springs and dampers, and the stance by feedforward
  /// torques.
  void StandHere() {
    QuadrupedDynamics dynamics;
    model.Calc(x, &dynamics);
    feedforward = StandingTorque(robot, model.gravity());
    const auto start = dynamics.feet;
    ground = [start, weight = 9.81 * robot.mass(), radius = robot.foot_radius](
                 const LeggedState& state, const QuadrupedDynamics& now, double) {
      FootForces forces;
      for (int leg = 0; leg < kNumLegs; ++leg) {
        const auto i = static_cast<std::size_t>(leg);
        const Vec<3> velocity = ContactJacobian(now, leg, radius) * Velocity(state);
        forces[leg] = -2e4 * (now.feet[i].p_W - start[i].p_W) - 200 * velocity;
        forces[leg][2] += weight / kNumLegs;
      }
      return forces;
    };
  }

  /// Joint PD, held until the next tick.
  Vec<12> Torque() const { return 200 * (joint_reference(t) - x.q) - 4 * x.qd + feedforward; }
  Vec<12> feedforward = Vec<12>::Zero();

  FootForces Feet() const {
    QuadrupedDynamics dynamics;
    model.Calc(x, &dynamics);
    return ground(x, dynamics, t);
  }
  /// The IMU of the robot without errors, under the torques of the interval that begins.
  ImuMeasurement Imu() const {
    const Vec<18> acceleration = Acceleration(x, Torque(), t);
    const Eigen::Matrix3d R_BW = x.R_WB().transpose();
    const Vec<3> arm = x.R_WB() * robot.imu_B, alpha = acceleration.segment<3>(3);
    const Vec<3> a = acceleration.head<3>() + alpha.cross(arm) + x.w_W.cross(x.w_W.cross(arm));
    return {R_BW * x.w_W, R_BW * (a + Vec<3>(0, 0, 9.81))};
  }

  /// To the next tick, by the classical Runge-Kutta method.
  void Step() {
    const Vec<12> torque = Torque();
    constexpr int kSteps = 4;
    const double h = kPeriod / kSteps;
    for (int i = 0; i < kSteps; ++i) {
      const LeggedState k1 = Rate(x, torque, t), k2 = Rate(Plus(x, h / 2, k1), torque, t + h / 2),
                        k3 = Rate(Plus(x, h / 2, k2), torque, t + h / 2),
                        k4 = Rate(Plus(x, h, k3), torque, t + h);
      x = Plus(Plus(Plus(Plus(x, h / 6, k1), h / 3, k2), h / 3, k3), h / 6, k4);
      x.q_WB.normalize();
      t += h;
    }
    t = kPeriod * std::round(t / kPeriod);
  }

  static Vec<18> Velocity(const LeggedState& state) {
    Vec<18> nu;
    nu << state.v_W, state.w_W, state.qd;
    return nu;
  }
  /// The Jacobian of the lowest point of a foot, carried by the shank.
  static DynamicsMatrix<3, 18> ContactJacobian(const QuadrupedDynamics& dynamics, int leg, double radius) {
    return PointJacobian(dynamics, leg, dynamics.feet[leg].p_W - Vec<3>(0, 0, radius));
  }
  /// The Jacobian of a point that the shank carries.
  static DynamicsMatrix<3, 18> PointJacobian(const QuadrupedDynamics& dynamics, int leg, const Vec<3>& p_W) {
    DynamicsMatrix<3, 18> J = DynamicsMatrix<3, 18>::Zero();
    const Vec<3> r = p_W - dynamics.base_W;
    J.leftCols<3>().setIdentity();
    J.middleCols<3>(3) << 0, r[2], -r[1], -r[2], 0, r[0], r[1], -r[0], 0;
    J.middleCols<3>(6 + 3 * leg) = dynamics.LegJacobian(leg, p_W);
    return J;
  }

  Vec<18> Acceleration(const LeggedState& state, const Vec<12>& torque, double time) const {
    QuadrupedDynamics dynamics;
    model.Calc(state, &dynamics);
    const FootForces feet = ground(state, dynamics, time);
    Vec<18> right = external(state, dynamics, time) - dynamics.bias();
    right.tail<12>() += torque;
    for (int leg = 0; leg < kNumLegs; ++leg)
      right += ContactJacobian(dynamics, leg, robot.foot_radius).transpose() * feet[leg];
    return Solve(dynamics.M, right);
  }

 private:
  LeggedState Rate(const LeggedState& state, const Vec<12>& torque, double time) const {
    const Vec<18> a = Acceleration(state, torque, time);
    return {state.v_W,   QuaternionRate(state.q_WB, state.w_W), state.qd, a.head<3>(), a.segment<3>(3),
            a.tail<12>()};
  }
  static LeggedState Plus(const LeggedState& state, double h, const LeggedState& rate) {
    return {state.p_WB + h * rate.p_WB, state.q_WB + h * rate.q_WB, state.q + h * rate.q,
            state.v_W + h * rate.v_W,   state.w_W + h * rate.w_W,   state.qd + h * rate.qd};
  }
};

/// The bench under an observer, from its first tick at t = 0 on.
template <class Observer>
class Observed {
 public:
  template <class Params>
  Observed(QuadrupedBench bench_in, const Params& params) : bench(std::move(bench_in)), rig(params) {
    Look();
  }
  const auto& Tick() {
    bench.Step();
    Look();
    return estimate();
  }
  const auto& RunTo(double time) {
    while (bench.t < time - 1e-9) Tick();
    return estimate();
  }
  const auto& estimate() { return rig[rig.system().estimate]; }

  QuadrupedBench bench;
  TestRig<Observer> rig;

 private:
  void Look() {
    auto& observer = rig.system();
    rig.Fix(observer.state, bench.x).Fix(observer.foot_forces, bench.Feet());
    if constexpr (requires { observer.torque; }) rig.Fix(observer.torque, bench.Torque());
    if constexpr (requires { observer.imu; }) rig.Fix(observer.imu, bench.Imu());
    rig.Tick();
  }
};

}  // namespace tenon::test
