#include <tenon/controllers/legged/whole_body/rope_tensions.h>
#include <tenon/controllers/legged/whole_body/whole_body_qp.h>
#include <tenon/plants/model/cross_matrix.h>
#include <tenon/plants/signals/quaternion.h>

#include <Eigen/Geometry>
#include <fmt/core.h>

#include <algorithm>
#include <numbers>

namespace tenon {
namespace {

constexpr double kRegularity = 1e-6;  // e, which selects the smallest of equivalent tensions
// e_1 to e_3: weights of the tensions' change, and of the feet's forces along the ground and its normal.
constexpr double kOfTension = 1e-4, kOfFriction = 1e-3, kOfLoad = 1e-5;
// A rope is lost after kLostTime [s] with less than kLostRatio of its command, if that exceeds kLeastPull of
// the weight.
constexpr double kLostTime = 0.05, kLostRatio = 0.3, kLeastPull = 0.01;
constexpr double kStiffness = 25, kDamping = 10;  // k_p [1/s^2] and k_d [1/s] while it hangs

constexpr int kFeet = 3 * kNumLegs, kVariables = kMaxRopes + kFeet;
using BoundMatrix = Eigen::Matrix<double, 2 * kMaxRopes, kMaxRopes, Eigen::RowMajor>;

BoundMatrix BothSides() {
  BoundMatrix sides;
  sides << Eigen::Matrix4d::Identity(), -Eigen::Matrix4d::Identity();
  return sides;
}

QpReport Checked(const QpReport& report) {
  if (!report.ok()) throw RunError("the tensions of the ropes cannot be computed: " + report.Message());
  return report;
}

}  // namespace

void RopeTensionsParams::Validate() const {
  CheckRopes(ropes);
  Demand(robot.mass() > 0, "the robot has no mass; give a robot, as LoadQuadruped reads it");
  Demand(friction > 0, fmt::format("friction = {} must be positive; give a coefficient above 0", friction));
}

void RopeTensions::CalcLimbs(const LeggedState& state, Limbs* limbs) const {
  QuadrupedDynamics dynamics;
  model_.Calc(state, &dynamics);
  limbs->ropes.setZero();
  for (std::size_t i = 0; i < params.ropes.size(); ++i) {
    const RopeLine line = LineOf(params.ropes[i], state);
    const Vec<3> arm = state.p_WB + line.arm_W - dynamics.com_W;
    limbs->ropes.col(static_cast<Eigen::Index>(i)) << line.direction_W, arm.cross(line.direction_W);
  }
  for (std::size_t i = 0; i < kNumLegs; ++i) limbs->feet[i] = dynamics.feet[i].p_W - dynamics.com_W;
  limbs->com_W = dynamics.com_W;
  limbs->com_velocity_W = dynamics.com_velocity_W;
  limbs->w_W = state.w_W;
  limbs->q_WB = state.q_WB;
  limbs->inertia_W = dynamics.centroidal_inertia_W;
}

/// Lost ropes, and those that the robot does not have, are bounded by zero.
RopeTensions::Bounds RopeTensions::BoundsOf(const Watch& watch) const {
  Bounds bounds{Vec<kMaxRopes>::Zero(), Vec<kMaxRopes>::Zero()};
  for (std::size_t i = 0; i < params.ropes.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    if (watch.missing[k] >= kLostTime) continue;
    bounds.lower[k] = params.ropes[i].tension_min;
    bounds.upper[k] = params.ropes[i].tension_max;
  }
  return bounds;
}

Vec<kMaxRopes> RopeTensions::Nominal(const UnitWrenches& ropes, const Vec<3>& normal, const Bounds& bounds,
                                     double share, DualActiveSet& solver) const {
  const Eigen::Vector3d force =
      share * model_.mass() * model_.gravity() * (Eigen::Vector3d::UnitZ() - normal[2] * normal);
  UnitWrenches weighted = ropes;
  weighted.bottomRows<3>() /= params.robot.StanceHeight() * params.robot.StanceHeight();
  Eigen::Matrix4d H = ropes.transpose() * weighted;
  H.diagonal().array() += kRegularity;
  const Eigen::Vector4d g = -ropes.topRows<3>().transpose() * force;
  Eigen::Matrix<double, 2 * kMaxRopes, 1> limits;
  limits << bounds.lower, -bounds.upper;
  Checked(solver.Solve({H, g, ConstraintMatrix(0, kMaxRopes), Eigen::VectorXd(0), BothSides(), limits}));
  return solver.x();
}

void RopeTensions::CalcCommand(const Limbs& limbs, const GroundPlane& ground, const ContactSchedule& schedule,
                               const BodyReference& body, const WrenchEstimate& external,
                               const CableVector& tension, double share, Watch& watch, Solvers& solvers,
                               CableVector* command) const {
  CheckNumCables(static_cast<int>(params.ropes.size()), tension.size(), "RopeTensions");
  const Eigen::Index n = tension.size();
  const double weight = model_.mass() * model_.gravity();
  for (Eigen::Index i = 0; i < n; ++i) {
    const bool pulls = watch.command[i] < kLeastPull * weight || tension[i] >= kLostRatio * watch.command[i];
    if (watch.missing[i] < kLostTime) watch.missing[i] = pulls ? 0 : watch.missing[i] + params.rate.period();
  }
  const Bounds bounds = BoundsOf(watch);
  const Vec<3> normal = ground.Normal(), contact = ground.ContactArm(params.robot.foot_radius);
  const Vec<3> t_1 = FirstTangent(normal), t_2 = normal.cross(t_1);
  const Vec<kMaxRopes> nominal = Nominal(limbs.ropes, normal, bounds, share, solvers.nominal);
  Vec<6> wrench;
  wrench << model_.mass() * body.com_acceleration_W + weight * Vec<3>::UnitZ() - external.force_W,
      -external.torque_W;
  const auto stands = [&](int leg) {
    const ContactState state = schedule.legs[static_cast<std::size_t>(leg)].state;
    return state == ContactState::kStance || state == ContactState::kSwing;
  };
  int count = 0;
  for (int leg = 0; leg < kNumLegs; ++leg) count += stands(leg);
  if (count == 0) {
    const Eigen::AngleAxisd turn(RotationFromQuaternion(body.q_WB) *
                                 RotationFromQuaternion(limbs.q_WB).transpose());
    wrench.head<3>() += model_.mass() * (kStiffness * (body.com_W - limbs.com_W) +
                                         kDamping * (body.com_velocity_W - limbs.com_velocity_W));
    wrench.tail<3>() +=
        limbs.inertia_W * (kStiffness * turn.angle() * turn.axis() + kDamping * (body.w_W - limbs.w_W));
  }

  // The variables are the tensions, then the forces of the feet along (n, t_1, t_2).
  Eigen::Matrix<double, 6, kVariables> limb = Eigen::Matrix<double, 6, kVariables>::Zero();
  Eigen::Matrix<double, kVariables, 1> weights, wanted;
  weights.head<kMaxRopes>().setConstant(kOfTension);
  wanted << nominal, Eigen::Matrix<double, kFeet, 1>::Zero();
  constexpr int kRows = 2 * kMaxRopes + 4 * kNumLegs;
  Eigen::Matrix<double, kRows, kVariables, Eigen::RowMajor> A;
  Eigen::Matrix<double, kRows, 1> b;
  A.setZero();
  A.topLeftCorner<2 * kMaxRopes, kMaxRopes>() = BothSides();
  b << bounds.lower, -bounds.upper, Eigen::Matrix<double, 4 * kNumLegs, 1>::Constant(-1);
  limb.leftCols<kMaxRopes>() = limbs.ropes;
  Eigen::Matrix3d axes;
  axes << normal, t_1, t_2;
  // The shares of one foot in the wanted force, and in what the nominal tensions leave of it.
  const Vec<3> force = wrench.head<3>() / std::max(count, 1);
  const Vec<3> loads = force - limbs.ropes.topRows<3>() * nominal / std::max(count, 1);
  const double side = params.friction * std::numbers::sqrt2 / 2;
  for (int leg = 0; leg < kNumLegs; ++leg) {
    const int column = kMaxRopes + 3 * leg, row = 2 * kMaxRopes + 4 * leg;
    weights.segment<3>(column) << kOfLoad, kOfFriction, kOfFriction;
    if (!stands(leg)) continue;  // its force is zero because it costs and has no effect
    limb.block<3, 3>(0, column) = axes;
    limb.block<3, 3>(3, column) = CrossMatrix(limbs.feet[static_cast<std::size_t>(leg)] + contact) * axes;
    wanted.segment<3>(column) << loads.dot(normal), (1 - share) * force.dot(t_1),
        (1 - share) * force.dot(t_2);
    b.segment<4>(row).setZero();
    A.block<4, 3>(row, column) << side, 1, 0, side, -1, 0, side, 0, 1, side, 0, -1;
  }
  Eigen::Matrix<double, 6, kVariables> weighted = limb;
  weighted.bottomRows<3>() /= params.robot.StanceHeight() * params.robot.StanceHeight();
  Eigen::Matrix<double, kVariables, kVariables> H = limb.transpose() * weighted;
  H.diagonal() += weights;
  const Eigen::Matrix<double, kVariables, 1> g =
      -(weighted.transpose() * wrench) - weights.cwiseProduct(wanted);
  Checked(solvers.joint.Solve({H, g, ConstraintMatrix(0, kVariables), Eigen::VectorXd(0), A, b}));
  for (Eigen::Index i = 0; i < n; ++i) watch.command[i] = (*command)[i] = solvers.joint.x()[i];
}

WrenchEstimate RopeTensions::CalcWrench(const Limbs& limbs, const CableVector& tension) const {
  CheckNumCables(static_cast<int>(params.ropes.size()), tension.size(), "RopeTensions");
  const Vec<6> sum = limbs.ropes.leftCols(tension.size()) * tension;
  return {sum.head<3>(), sum.tail<3>()};
}

CableVector RopeTensions::CommandAt(const LeggedState& state, const GroundPlane& ground,
                                    const ContactSchedule& schedule) const {
  Limbs limbs;
  CalcLimbs(state, &limbs);
  const BodyReference rest{
      .com_W = limbs.com_W, .com_velocity_W = limbs.com_velocity_W, .q_WB = limbs.q_WB, .w_W = limbs.w_W};
  Watch watch;
  Solvers solvers;
  CableVector command = CableVector::Zero(static_cast<Eigen::Index>(params.ropes.size()));
  CalcCommand(limbs, ground, schedule, rest, {}, command, params.share, watch, solvers, &command);
  return command;
}

}  // namespace tenon
