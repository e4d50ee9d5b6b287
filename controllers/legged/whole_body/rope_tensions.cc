#include <tenon/controllers/legged/whole_body/rope_tensions.h>
#include <tenon/controllers/legged/whole_body/whole_body_qp.h>
#include <tenon/plants/model/vectors.h>

#include <fmt/core.h>

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
  robot.CheckMass();
  Demand(friction > 0, fmt::format("friction = {} must be positive; give a coefficient above 0", friction));
}

void RopeTensions::CalcLimbs(const LeggedState& state, Limbs* limbs) const {
  QuadrupedDynamics dynamics;
  model_.Calc(state, &dynamics);
  limbs->ropes.setZero();
  for (std::size_t i = 0; i < params.ropes.size(); ++i) {
    const RopeLine line = LineOf(params.ropes[i], state);
    const Vec<3> arm = state.p_WB + line.arm_W - dynamics.com_W;
    limbs->ropes.col(i) << line.direction_W, arm.cross(line.direction_W);
  }
  for (std::size_t i = 0; i < kNumLegs; ++i) limbs->feet[i] = dynamics.feet[i].p_W - dynamics.com_W;
  limbs->com_W = dynamics.com_W;
  limbs->com_velocity_W = dynamics.com_velocity_W;
  limbs->w_W = state.w_W;
  limbs->q_WB = state.q_WB;
  limbs->inertia_W = dynamics.centroidal_inertia_W;
}

/// Adds the last tick to the time for which each rope has lacked tension. A lost rope stays lost.
void RopeTensions::Watch(const CableVector& tension, Plan* memory) const {
  const double least = kLeastPull * model_.mass() * model_.gravity();
  for (Eigen::Index i = 0; i < tension.size(); ++i) {
    if (memory->missing[i] >= kLostTime) continue;
    const bool pulls = memory->command[i] < least || tension[i] >= kLostRatio * memory->command[i];
    memory->missing[i] = pulls ? 0 : memory->missing[i] + params.rate.period();
  }
}

/// Lost ropes, and those that the robot does not have, are bounded by zero.
RopeTensions::Bounds RopeTensions::BoundsOf(const Plan& memory) const {
  Bounds bounds{Vec<kMaxRopes>::Zero(), Vec<kMaxRopes>::Zero()};
  for (std::size_t i = 0; i < params.ropes.size(); ++i) {
    if (memory.missing[i] >= kLostTime) continue;
    bounds.lower[i] = params.ropes[i].tension_min;
    bounds.upper[i] = params.ropes[i].tension_max;
  }
  return bounds;
}

RopeTensions::Support RopeTensions::SupportOf(const GroundPlane& ground,
                                              const ContactSchedule& schedule) const {
  Support support;
  for (std::size_t i = 0; i < kNumLegs; ++i) {
    const ContactState state = schedule.legs[i].state;
    support.feet[i] = state == ContactState::kStance || state == ContactState::kSwing;
    support.count += support.feet[i];
  }
  support.normal = ground.Normal();
  support.t_1 = FirstTangent(support.normal);
  support.t_2 = support.normal.cross(support.t_1);
  support.contact = ground.ContactArm(params.robot.foot_radius);
  return support;
}

/// The wrench w that ropes and feet are to exert.
Vec<6> RopeTensions::WrenchOf(const Limbs& limbs, const BodyReference& body, const WrenchEstimate& external,
                              bool hangs) const {
  Vec<6> wrench;
  wrench << model_.mass() * (body.com_acceleration_W + model_.gravity() * Vec<3>::UnitZ()) - external.force_W,
      -external.torque_W;
  if (!hangs) return wrench;
  const Eigen::AngleAxisd turn(RotationFromQuaternion(body.q_WB) *
                               RotationFromQuaternion(limbs.q_WB).transpose());
  wrench.head<3>() += model_.mass() * (kStiffness * (body.com_W - limbs.com_W) +
                                       kDamping * (body.com_velocity_W - limbs.com_velocity_W));
  wrench.tail<3>() +=
      limbs.inertia_W * (kStiffness * turn.angle() * turn.axis() + kDamping * (body.w_W - limbs.w_W));
  return wrench;
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

/// Solves the program of ropes and feet, whose variables are the tensions, then the forces of the feet along
/// (n, t_1, t_2), and returns the tensions.
Vec<kMaxRopes> RopeTensions::Distribute(const Limbs& limbs, const Support& support, const Vec<6>& wrench,
                                        const Vec<kMaxRopes>& nominal, const Bounds& bounds, double share,
                                        DualActiveSet& solver) const {
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
  axes << support.normal, support.t_1, support.t_2;
  // The shares of one foot in the wanted force, and in what the nominal tensions leave of it.
  const int count = std::max(support.count, 1);
  const Vec<3> force = wrench.head<3>() / count;
  const Vec<3> loads = force - limbs.ropes.topRows<3>() * nominal / count;
  const double side = params.friction * std::numbers::sqrt2 / 2;
  for (int leg = 0; leg < kNumLegs; ++leg) {
    const int column = kMaxRopes + 3 * leg, row = 2 * kMaxRopes + 4 * leg;
    weights.segment<3>(column) << kOfLoad, kOfFriction, kOfFriction;
    if (!support.feet[leg]) continue;  // its force is zero because it costs and has no effect
    limb.block<3, 3>(0, column) = axes;
    limb.block<3, 3>(3, column) = CrossMatrix(limbs.feet[leg] + support.contact) * axes;
    wanted.segment<3>(column) << loads.dot(support.normal), (1 - share) * force.dot(support.t_1),
        (1 - share) * force.dot(support.t_2);
    b.segment<4>(row).setZero();
    A.block<4, 3>(row, column) << side, 1, 0, side, -1, 0, side, 0, 1, side, 0, -1;
  }
  Eigen::Matrix<double, 6, kVariables> weighted = limb;
  weighted.bottomRows<3>() /= params.robot.StanceHeight() * params.robot.StanceHeight();
  Eigen::Matrix<double, kVariables, kVariables> H = limb.transpose() * weighted;
  H.diagonal() += weights;
  const Eigen::Matrix<double, kVariables, 1> g =
      -(weighted.transpose() * wrench) - weights.cwiseProduct(wanted);
  Checked(solver.Solve({H, g, ConstraintMatrix(0, kVariables), Eigen::VectorXd(0), A, b}));
  return solver.x().head<kMaxRopes>();
}

void RopeTensions::CalcPlan(const Limbs& limbs, const GroundPlane& ground, const ContactSchedule& schedule,
                            const BodyReference& body, const WrenchEstimate& external,
                            const CableVector& tension, double share, Plan& memory, Solvers& solvers,
                            Plan* plan) const {
  CheckNumCables(static_cast<int>(params.ropes.size()), tension.size(), "RopeTensions");
  Watch(tension, &memory);
  const Bounds bounds = BoundsOf(memory);
  const Support support = SupportOf(ground, schedule);
  const Vec<6> wrench = WrenchOf(limbs, body, external, support.count == 0);
  const Vec<kMaxRopes> nominal = Nominal(limbs.ropes, support.normal, bounds, share, solvers.nominal);
  memory.command = Distribute(limbs, support, wrench, nominal, bounds, share, solvers.joint);
  *plan = memory;
}

void RopeTensions::CalcCommand(const Plan& plan, CableVector* command) const {
  *command = plan.command.head(command->size());
}

void RopeTensions::CalcLost(const Plan& plan, CableVector* lost) const {
  *lost = (plan.missing.head(lost->size()).array() >= kLostTime).cast<double>();
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
  Plan memory, plan;
  Solvers solvers;
  const CableVector slack = CableVector::Zero(static_cast<Eigen::Index>(params.ropes.size()));
  CalcPlan(limbs, ground, schedule, rest, {}, slack, params.share, memory, solvers, &plan);
  return plan.command.head(slack.size());
}

}  // namespace tenon
