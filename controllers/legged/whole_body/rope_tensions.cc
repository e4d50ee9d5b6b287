#include <tenon/controllers/legged/whole_body/rope_tensions.h>

#include <Eigen/Geometry>

namespace tenon {
namespace {

constexpr double kRegularity = 1e-6;  // e, which selects the smallest of equivalent tensions

}  // namespace

void RopeTensionsParams::Validate() const {
  CheckRopes(ropes);
  Demand(robot.mass() > 0, "the robot has no mass; give a robot, as LoadQuadruped reads it");
}

void RopeTensions::CalcUnitWrenches(const LeggedState& state, UnitWrenches* out) const {
  QuadrupedDynamics dynamics;
  model_.Calc(state, &dynamics);
  out->setZero();
  for (std::size_t i = 0; i < params.ropes.size(); ++i) {
    const RopeLine line = LineOf(params.ropes[i], state);
    const Vec<3> arm = state.p_WB + line.arm_W - dynamics.com_W;
    out->col(static_cast<Eigen::Index>(i)) << line.direction_W, arm.cross(line.direction_W);
  }
}

void RopeTensions::CalcCommand(const UnitWrenches& unit, const GroundPlane& ground, double share,
                               DualActiveSet& solver, CableVector* command) const {
  const auto n = static_cast<Eigen::Index>(params.ropes.size());
  const Eigen::Vector3d normal = ground.Normal();
  const Eigen::Vector3d force =
      share * model_.mass() * model_.gravity() * (Eigen::Vector3d::UnitZ() - normal[2] * normal);
  UnitWrenches weighted = unit;
  weighted.bottomRows<3>() /= params.robot.StanceHeight() * params.robot.StanceHeight();
  Eigen::Matrix4d H = unit.transpose() * weighted;
  H.diagonal().array() += kRegularity;
  const Eigen::Vector4d g = -unit.topRows<3>().transpose() * force;
  Eigen::Matrix<double, 2 * kMaxRopes, kMaxRopes, Eigen::RowMajor> bounds;
  bounds << Eigen::Matrix4d::Identity(), -Eigen::Matrix4d::Identity();
  Eigen::Matrix<double, 2 * kMaxRopes, 1> limits = Eigen::Matrix<double, 2 * kMaxRopes, 1>::Zero();
  for (std::size_t i = 0; i < params.ropes.size(); ++i) {
    limits[static_cast<Eigen::Index>(i)] = params.ropes[i].tension_min;
    limits[static_cast<Eigen::Index>(i) + kMaxRopes] = -params.ropes[i].tension_max;
  }
  const QpReport report =
      solver.Solve({H, g, ConstraintMatrix(0, kMaxRopes), Eigen::VectorXd(0), bounds, limits});
  if (!report.ok()) throw RunError("the tensions of the ropes cannot be computed: " + report.Message());
  for (Eigen::Index i = 0; i < n; ++i) (*command)[i] = solver.x()[i];
}

WrenchEstimate RopeTensions::CalcWrench(const UnitWrenches& unit, const CableVector& tension) const {
  CheckNumCables(static_cast<int>(params.ropes.size()), tension.size(), "RopeTensions");
  const Vec<6> sum = unit.leftCols(tension.size()) * tension;
  return {sum.head<3>(), sum.tail<3>()};
}

CableVector RopeTensions::CommandAt(const LeggedState& state, const GroundPlane& ground) const {
  UnitWrenches unit;
  CalcUnitWrenches(state, &unit);
  DualActiveSet solver(kMaxRopes, 2 * kMaxRopes);
  CableVector command(static_cast<Eigen::Index>(params.ropes.size()));
  CalcCommand(unit, ground, params.share, solver, &command);
  return command;
}

}  // namespace tenon
