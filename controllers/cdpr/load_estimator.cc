#include <tenon/controllers/cdpr/cdpr_kinematics.h>
#include <tenon/controllers/cdpr/load_estimator.h>
#include <tenon/controllers/cdpr/loaded_platform.h>
#include <tenon/plants/model/platform_springs.h>
#include <tenon/plants/model/rigid_inertia.h>
#include <tenon/plants/model/vectors.h>
#include <tenon/systems/analysis/internal/small_matrices.h>

#include <fmt/core.h>

namespace tenon {

void LoadEstimatorParams::Validate() const {
  Demand(bandwidth * rate.period() < 1,
         fmt::format("bandwidth = {} rad/s is too much at {} Hz: it must be below the rate", bandwidth,
                     1 / rate.period()));
}

LoadEstimate LoadEstimator::CalcLoad(const PlatformEstimate& estimate, const ImuMeasurement& inertial,
                                     const CableSignals& cables, const PlatformWrench& known,
                                     double bandwidth, Memory& memory) const {
  const CdprDescription& robot = params.robot;
  CheckNumCables(robot.num_cables(), cables.tension.size(), "LoadEstimator");
  const double h = params.rate.period();
  const Eigen::Matrix3d R_WB = estimate.platform.R_WB();
  Vector6d pull;
  pull << known.force_W, known.torque_W;
  pull += CalcSpringWrench(robot.springs, estimate.platform.p_WB, R_WB);
  for (int i = 0; i < robot.num_cables(); ++i)
    pull += cables.tension[i] *
            CalcCableLine(robot, i, estimate.platform.p_WB, R_WB, anchors, estimate.time).wrench;
  const Eigen::Vector3d w = R_WB * inertial.angular_velocity_B;
  Eigen::Vector3d specific_force = R_WB * inertial.specific_force_B;
  if (robot.on_table) specific_force[2] = 0;  // the table carries the weight
  const Eigen::Vector3d momentum = R_WB * (robot.inertia_B * inertial.angular_velocity_B);
  if (!memory.started) {
    memory.started = true;
    memory.momentum_W = momentum;
    memory.specific_force_W = specific_force;
    memory.angular_velocity_W = w;
    Eigen::Map<Eigen::Matrix3d>(memory.arm_covariance.data())
        .diagonal()
        .setConstant(std::pow(params.arm_deviation, 2));
  }

  const double keep = std::exp(-bandwidth * h);
  const auto follow = [keep](const Eigen::Vector3d& now, Vec<3>& filtered) {
    filtered = now + keep * (filtered - now);
  };
  const Eigen::Vector3d torque = bandwidth * (momentum - memory.momentum_W);
  const Eigen::Vector3d alpha = (1 - keep) / h * (w - memory.angular_velocity_W);
  memory.momentum_W += h * (pull.tail<3>() + torque);
  follow(robot.mass * specific_force - pull.head<3>(), memory.force_W);
  follow(specific_force, memory.specific_force_W);
  follow(w, memory.angular_velocity_W);
  const Eigen::Vector3d force = memory.force_W;

  CorrectArm(R_WB.transpose() * force, R_WB.transpose() * torque, memory);
  const Eigen::Vector3d arm_W = R_WB * memory.arm_B, turning = memory.angular_velocity_W;
  const Eigen::Vector3d y =
      memory.specific_force_W + alpha.cross(arm_W) + turning.cross(turning.cross(arm_W));
  constexpr double kLeast = 1;  // least |y| at which a mass is observable [m/s^2]
  if (y.norm() > kLeast) {
    const double mass = -force.dot(y) / y.squaredNorm();
    memory.mass = mass + std::exp(-params.mass_bandwidth * h) * (memory.mass - mass);
  }

  LoadEstimate load;
  if (memory.mass > params.least_mass * robot.mass) load.payload = {memory.mass, memory.arm_B};
  const Eigen::Vector3d carried = -load.payload.mass * y;
  const double keep_rest = std::exp(-params.rest_bandwidth * h);
  const Eigen::Vector3d rest_force = force - carried, rest_torque = torque - arm_W.cross(carried);
  PlatformWrench& rest = memory.rest;
  rest.force_W = rest_force + keep_rest * (rest.force_W - rest_force);
  rest.torque_W = rest_torque + keep_rest * (rest.torque_W - rest_torque);
  load.rest = {rest.force_W + known.force_W, rest.torque_W + known.torque_W};
  return load;
}

void LoadEstimator::CorrectArm(const Eigen::Vector3d& force_B, const Eigen::Vector3d& torque_B,
                               Memory& memory) const {
  Eigen::Map<Eigen::Matrix3d> P(memory.arm_covariance.data());
  P.diagonal().array() += params.rate.period() * params.arm_walk * params.arm_walk;
  P.diagonal() = P.diagonal().cwiseMin(std::pow(params.arm_deviation, 2));
  const Eigen::Matrix3d H = -CrossMatrix(force_B);  // r x F = H r
  const Eigen::Matrix3d HP = H * P;
  Eigen::Matrix3d S = HP * H.transpose();
  S.diagonal().array() += std::pow(params.torque_deviation, 2);
  const Eigen::Matrix3d gain_transposed = internal::Cholesky<3>(S).Solve<3>(HP);
  const Eigen::Vector3d innovation = torque_B - H * memory.arm_B;
  memory.arm_B += gain_transposed.transpose() * innovation;
  const Eigen::Matrix3d reduced = P - HP.transpose() * gain_transposed;
  P = (reduced + reduced.transpose()) / 2;
}

LoadedPlatform::LoadedPlatform(const CdprDescription& robot, const Payload& payload)
    : mass(robot.mass), inertia(robot.inertia_B) {
  if (payload.mass == 0) return;
  mass += payload.mass;
  com_B = payload.mass / mass * payload.p_B;
  inertia += PointInertia(robot.mass, com_B) + PointInertia(payload.mass, payload.p_B - com_B);
}

}  // namespace tenon
