#include <tenon/controllers/cdpr/cdpr_kinematics.h>
#include <tenon/controllers/optimization/infinity.h>
#include <tenon/plants/model/platform_springs.h>
#include <tenon/plants/model/rigid_inertia.h>
#include <tenon/plants/model/swivel_pulley.h>
#include <tenon/plants/model/vectors.h>
#include <tenon/systems/analysis/internal/small_matrices.h>
#include <tenon/systems/analysis/matrix_functions.h>

#include <fmt/format.h>

#include <algorithm>

namespace tenon {
namespace {

constexpr double kShortestCable = 1e-9;  // [m]
constexpr double kSlackTension = 1e-9;   // [m g]
constexpr double kRankTolerance = 1e-9;
constexpr double kInPlane = 1e-9;  // [m]

/// Extends `line` over a pulley; its arm must be set, and `reach` is the vector from attachment to anchor.
void LeadOverPulley(const CdprDescription& robot, int index, const Eigen::Matrix3d& R_WB,
                    const Eigen::Vector3d& reach, CableLine& line) {
  const bool carried = robot.carries_pulley(index);
  const Eigen::Vector3d span = carried ? Eigen::Vector3d(R_WB.transpose() * -reach) : reach;
  const double radius = robot.pulley_radius(index), x = std::hypot(span.x(), span.y()), z = -span.z();
  const double from_centre = std::hypot(x - radius, z);
  if (x <= 0 || from_centre <= radius) {  // NaN and infinity pass and propagate
    throw RunError(fmt::format(
        "Cable {} of '{}' would end {:.4g} m beside the swivel axis of its pulley and {:.4g} m away "
        "from the pulley's centre, whose radius is {} m: keep the platform off both, or give a smaller "
        "pulley_radius_m.",
        index, robot.name, x, from_centre, radius));
  }
  const StraightLead lead = LeadStraight(radius, span);
  if (!carried) line.exit_W += lead.exit_W;
  line.direction = lead.direction_W;
  line.free_length = lead.contact.free_length;
  line.length = lead.length;
  const double sideways = 1 / lead.contact.free_length - std::sin(lead.contact.wrap) / x;
  line.swivel =
      std::sqrt(std::max(sideways, 0.0)) * Eigen::Vector3d(-lead.outwards_W.y(), lead.outwards_W.x(), 0);
  if (!carried) return;
  line.arm_W += R_WB * lead.exit_W;
  line.direction = R_WB * -lead.direction_W;
  line.swivel = (R_WB * line.swivel).eval();
}

/// u P of cable i, see CalcWrenchJacobian(): minus the derivative of its force by its attachment's position
/// [N/m].
Eigen::Matrix3d DirectionRate(const CableKinematics& cables, int i, double tension) {
  const Eigen::Vector3d direction = cables.direction.col(i);
  Eigen::Matrix3d rate =
      tension / cables.free_length[i] * (Eigen::Matrix3d::Identity() - direction * direction.transpose());
  if (cables.swivel.cols() > 0) rate -= tension * cables.swivel.col(i) * cables.swivel.col(i).transpose();
  return rate;
}

/// The vector from the CoM to the anchor of a cable that leaves the platform over a pulley.
Eigen::Vector3d ToAnchor(const CableKinematics& cables, int i) {
  return cables.arm_W.col(i) + cables.free_length[i] * cables.direction.col(i);
}

/// Adds the part of cable i to d(W u)/dtheta, six rows; `rate` is its DirectionRate().
template <class Columns>
void AddWrenchByTurn(const CableKinematics& cables, int i, double tension, const Eigen::Matrix3d& rate,
                     Columns&& columns) {
  if (cables.carried) {
    const Eigen::Matrix3d to_anchor = CrossMatrix(ToAnchor(cables, i));
    const Eigen::Matrix3d force_by_turn = rate * to_anchor - tension * CrossMatrix(cables.direction.col(i));
    columns.template topRows<3>() += force_by_turn;
    columns.template bottomRows<3>() += to_anchor * force_by_turn;
    return;
  }
  const Eigen::Matrix3d arm = CrossMatrix(cables.arm_W.col(i));
  columns.template topRows<3>() += rate * arm;
  columns.template bottomRows<3>() += arm * rate * arm + tension * CrossMatrix(cables.direction.col(i)) * arm;
}

}  // namespace

CableLine CalcCableLine(const CdprDescription& robot, int index, const Eigen::Vector3d& p_WB,
                        const Eigen::Matrix3d& R_WB) {
  const CableDescription& cable = robot.cables[index];
  CableLine line;
  line.arm_W = R_WB * cable.attachment_B;
  const Eigen::Vector3d span = cable.anchor_W - p_WB - line.arm_W;
  line.length = span.norm();
  if (line.length < kShortestCable) {
    throw RunError(
        fmt::format("Cable {} of '{}' has no length: its attachment is at its anchor "
                    "({:.4g}, {:.4g}, {:.4g}) m.",
                    index, robot.name, cable.anchor_W.x(), cable.anchor_W.y(), cable.anchor_W.z()));
  }
  line.exit_W = cable.anchor_W;
  line.free_length = line.length;
  line.direction = span / line.length;
  if (robot.pulley_radius(index) > 0) LeadOverPulley(robot, index, R_WB, span, line);
  line.wrench << line.direction, line.arm_W.cross(line.direction);
  return line;
}

CableLine CalcCableLine(const CdprDescription& robot, int index, const Eigen::Vector3d& p_WB,
                        const Eigen::Matrix3d& R_WB, const MovingAnchors& anchors, double time) {
  if (!anchors.any()) return CalcCableLine(robot, index, p_WB, R_WB);
  const PathPoint moved = anchors.At(index, time);
  CableLine line = CalcCableLine(robot, index, p_WB - moved.position, R_WB);
  line.exit_W += moved.position;
  line.anchor_rate = line.direction.dot(moved.velocity);
  return line;
}

void CalcCableKinematics(const CdprDescription& robot, const Eigen::Vector3d& p_WB,
                         const Eigen::Matrix3d& R_WB, CableKinematics* cables, const MovingAnchors& anchors,
                         double time) {
  const int n = robot.num_cables();
  cables->arm_W.resize(3, n);
  cables->exit_W.resize(3, n);
  cables->direction.resize(3, n);
  cables->length.resize(n);
  cables->free_length.resize(n);
  cables->swivel.resize(3, robot.has_pulleys() ? n : 0);
  cables->structure.resize(6, n);
  cables->carried = robot.winch.pulleys_on_platform && robot.has_pulleys();
  for (int i = 0; i < n; ++i) {
    const CableLine line = CalcCableLine(robot, i, p_WB, R_WB, anchors, time);
    cables->arm_W.col(i) = line.arm_W;
    cables->exit_W.col(i) = line.exit_W;
    cables->direction.col(i) = line.direction;
    cables->length[i] = line.length;
    cables->free_length[i] = line.free_length;
    if (cables->swivel.cols() > 0) cables->swivel.col(i) = line.swivel;
    cables->structure.col(i) = line.wrench;
  }
}

CableKinematics CalcCableKinematics(const CdprDescription& robot, const Eigen::Vector3d& p_WB,
                                    const Eigen::Matrix3d& R_WB) {
  CableKinematics cables;
  CalcCableKinematics(robot, p_WB, R_WB, &cables);
  return cables;
}

std::optional<CablePlane> PlaneOf(const CdprDescription& robot) {
  if (robot.on_table) return CablePlane{2, robot.cables[0].anchor_W.z(), {0, 1, 5}};
  for (const int normal : {0, 1}) {
    const double at = robot.cables[0].anchor_W[normal];
    const auto lies = [&](const auto& each) {  // a cable or a spring
      return std::abs(each.anchor_W[normal] - at) < kInPlane &&
             std::abs(each.attachment_B[normal]) < kInPlane;
    };
    const auto stays = [&](const CableDescription& cable) {
      return !cable.anchor_path || std::ranges::all_of(cable.anchor_path->offsets, [&](const auto& offset) {
        return std::abs(offset[normal]) < kInPlane;
      });
    };
    if (std::ranges::all_of(robot.cables, lies) && std::ranges::all_of(robot.cables, stays) &&
        std::ranges::all_of(robot.springs, lies))
      return CablePlane{normal, at, {1 - normal, 2, 3 + normal}};
  }
  return {};
}

std::vector<int> MotionsOf(const CdprDescription& robot) {
  std::vector<int> motions{0, 1, 2, 3, 4, 5};
  if (const auto plane = PlaneOf(robot)) motions.assign(plane->motions.begin(), plane->motions.end());
  const bool at_com = robot.cables[0].attachment_B.isZero(0);
  if (robot.ends_in_one_point())
    std::erase_if(motions, [at_com](int motion) { return motion == 5 || (at_com && motion > 2); });
  return motions;
}

Vector6d GravityWrench(const CdprDescription& robot) {
  Vector6d wrench = Vector6d::Zero();
  if (!robot.on_table) wrench[2] = -robot.mass * kGravity;
  return wrench;
}

Vector6d PassiveWrench(const CdprDescription& robot, const Eigen::Vector3d& p_WB, const Eigen::Matrix3d& R_WB,
                       Matrix6d* jacobian) {
  return GravityWrench(robot) + CalcSpringWrench(robot.springs, p_WB, R_WB, jacobian);
}

Eigen::Matrix<double, 6, 3> CalcWrenchByTurn(const CableKinematics& cables, const CableVector& tension) {
  Eigen::Matrix<double, 6, 3> by_turn = Eigen::Matrix<double, 6, 3>::Zero();
  for (int i = 0; i < cables.num_cables(); ++i)
    AddWrenchByTurn(cables, i, tension[i], DirectionRate(cables, i, tension[i]), by_turn);
  return by_turn;
}

Matrix6d CalcWrenchJacobian(const CableKinematics& cables, const CableVector& tension) {
  Matrix6d jacobian = Matrix6d::Zero();
  for (int i = 0; i < cables.num_cables(); ++i) {
    const Eigen::Matrix3d rate = DirectionRate(cables, i, tension[i]);
    jacobian.topLeftCorner<3, 3>() -= rate;
    if (cables.carried)
      jacobian.bottomLeftCorner<3, 3>() +=
          tension[i] * CrossMatrix(cables.direction.col(i)) - CrossMatrix(ToAnchor(cables, i)) * rate;
    else
      jacobian.bottomLeftCorner<3, 3>() -= CrossMatrix(cables.arm_W.col(i)) * rate;
    AddWrenchByTurn(cables, i, tension[i], rate, jacobian.rightCols<3>());
  }
  return jacobian;
}

double CalcLockedStiffness(const CdprDescription& robot, const CableKinematics& cables,
                           const Eigen::Vector3d& p_WB, const Eigen::Matrix3d& R_WB,
                           const CableVector& tension) {
  // Substitutes x = S y with S^T M S = 1.
  const Eigen::Matrix3d root = R_WB * internal::Cholesky<3>(robot.inertia_B).Lower();
  Eigen::MatrixXd S = Matrix6d::Zero();
  S.topLeftCorner<3, 3>() = Eigen::Matrix3d::Identity() / std::sqrt(robot.mass);
  S.bottomRightCorner<3, 3>() = internal::Inverse<3>(root.transpose());

  if (robot.on_table) {
    const Matrix6d one = Matrix6d::Identity() / std::sqrt(robot.mass);
    S = one(Eigen::all, std::vector<int>{0, 1, 5});
  }

  // Cables without tension may go slack and do not constrain the platform.
  std::vector<int> taut;
  for (int i = 0; i < cables.num_cables(); ++i) {
    if (tension[i] > kSlackTension * robot.mass * kGravity) taut.push_back(i);
  }
  if (taut.empty()) return -kInfinity;
  const Eigen::MatrixXd structure = S.transpose() * cables.structure(Eigen::all, taut);
  const RangeBasis range = CalcRangeBasis(structure, kRankTolerance);
  const int freedoms = static_cast<int>(S.cols() - range.rank);
  if (freedoms == 0) return kInfinity;

  const Eigen::MatrixXd motions = S * range.Q.rightCols(freedoms);
  Matrix6d passive;
  PassiveWrench(robot, p_WB, R_WB, &passive);
  const Eigen::MatrixXd K = -motions.transpose() * (CalcWrenchJacobian(cables, tension) + passive) * motions;
  return robot.mass * SymmetricEigenvalues((K + K.transpose()) / 2)[0];
}

Matrix6d CalcElasticStiffness(const CdprDescription& robot, const CableKinematics& cables,
                              const Eigen::Vector3d& p_WB, const Eigen::Matrix3d& R_WB,
                              const CableVector& tension) {
  Matrix6d passive;
  PassiveWrench(robot, p_WB, R_WB, &passive);
  Matrix6d stiffness = -CalcWrenchJacobian(cables, tension) - passive;
  for (int i = 0; i < cables.num_cables(); ++i) {
    const Vector6d column = cables.structure.col(i);
    stiffness += (robot.cable.axial_stiffness + tension[i]) / cables.length[i] * column * column.transpose();
  }
  return (stiffness + stiffness.transpose()) / 2;
}

double CalcLeastTranslationalStiffness(const Matrix6d& stiffness) {
  const internal::Cholesky<6> factors(stiffness);
  if (!factors.positive()) return 0;
  const Matrix6d compliance = factors.Solve<6>(Matrix6d::Identity());
  return 1 / SymmetricEigenvalues(compliance.topLeftCorner<3, 3>())[2];
}

CableVector CalcRestLengths(const CableProperties& cable, const CableVector& length,
                            const CableVector& tension) {
  return length.array() / (1 + tension.array() / cable.axial_stiffness);
}

}  // namespace tenon
