#include <tenon/controllers/cdpr/inverse_geometrico_static.h>
#include <tenon/controllers/cdpr/tension_distribution.h>
#include <tenon/controllers/optimization/infinity.h>
#include <tenon/plants/model/rigid_inertia.h>
#include <tenon/plants/signals/euler.h>
#include <tenon/systems/analysis/internal/small_matrices.h>
#include <tenon/systems/analysis/matrix_functions.h>

#include <fmt/format.h>
#include <nlopt.hpp>

#include <numbers>
#include <numeric>

namespace tenon {
namespace {

constexpr double kStartAngle = 0.6;         // largest angle of the grid of starts [rad]
constexpr double kLargestAngle = 1.4;       // largest roll, pitch and yaw of a result [rad]
constexpr double kLargestNewtonStep = 0.2;  // saturation of a Newton step [rad]
constexpr double kBoundTolerance = 1e-9;    // tolerance of a tension at a bound [m g]
constexpr double kLeastExcess = 1e-6;       // least excess over a bound that is reported [N]
constexpr double kInPlane = 1e-9;           // distance from the plane of a planar robot [m]
constexpr double kLeastStiffness = 1e-6;    // least stiffness of a stable equilibrium [N/m]

using Eigen::MatrixXd;
using Eigen::VectorXd;

// State of each tension: -1 fixed at the lower bound, 1 fixed at the upper bound, 0 free.
using ActiveSet = std::vector<int>;

// min |u|^2 / 2 subject to F(x) = 0 and lower <= u <= upper, with x = [Theta; u]. Tensions and forces are in
// units of the weight m g, torques in units of m g times the longest arm. Theta has the angles, and F the
// equations, of the motions that the cables govern (MotionsOf).
class StaticsProblem {
 public:
  StaticsProblem(const CdprDescription& robot, const Eigen::Vector3d& p_WB, const CableVector& tension_min,
                 const CableVector& tension_max)
      : robot_(robot),
        p_WB_(p_WB),
        weight_(robot.mass * kGravity),
        lower_(tension_min / weight_),
        upper_(tension_max / weight_),
        equations_(MotionsOf(robot)) {
    for (const CableDescription& cable : robot.cables) arm_ = std::max(arm_, cable.attachment_B.norm());
    if (!(arm_ > 0)) arm_ = 1;
    for (const int motion : equations_)
      if (motion > 2) angles_.push_back(motion - 3);
  }

  int num_angles() const { return static_cast<int>(angles_.size()); }
  int num_equations() const { return static_cast<int>(equations_.size()); }
  int num_unknowns() const { return num_angles() + robot_.num_cables(); }
  Eigen::Vector3d Euler(const VectorXd& x) const {
    Eigen::Vector3d euler = Eigen::Vector3d::Zero();
    euler(angles_) = x.head(num_angles());
    return euler;
  }
  VectorXd At(const StaticEquilibrium& equilibrium) const {
    VectorXd x(num_unknowns());
    x << equilibrium.euler(angles_), equilibrium.tension / weight_;
    return x;
  }
  CableVector Tension(const VectorXd& x) const { return weight_ * x.tail(robot_.num_cables()); }

  VectorXd Residual(const VectorXd& x, MatrixXd* jacobian) const {
    const int n = robot_.num_cables();
    const Eigen::Vector3d euler = Euler(x);
    const CableVector u = x.tail(n);
    const CableKinematics cables = CalcCableKinematics(robot_, p_WB_, RotationFromEuler(euler));
    Vector6d residual = cables.structure * u;
    Matrix6d passive;
    residual += PassiveWrench(robot_, p_WB_, RotationFromEuler(euler), &passive) / weight_;
    residual.tail<3>() /= arm_;
    if (jacobian) {
      Eigen::Matrix<double, 6, 3> by_angles =
          (CalcWrenchJacobian(cables, u) + passive / weight_).rightCols<3>() * EulerRateMatrix(euler);
      CableMatrix6 structure = cables.structure;
      by_angles.bottomRows<3>() /= arm_;
      structure.bottomRows<3>() /= arm_;
      jacobian->resize(num_equations(), num_unknowns());
      *jacobian << by_angles(equations_, angles_), structure(equations_, Eigen::all);
    }
    return residual(equations_);
  }

  // The tensions with the least residual at an attitude, clamped to the bounds.
  VectorXd Start(const Eigen::Vector3d& euler) const {
    VectorXd x = VectorXd::Zero(num_unknowns());
    x.head(num_angles()) = euler(angles_);
    MatrixXd jacobian;
    const VectorXd residual = Residual(x, &jacobian);
    const MatrixXd structure = jacobian.rightCols(robot_.num_cables());
    x.tail(robot_.num_cables()) = SolveLeastSquaresBasic(structure, -residual);
    Clamp(&x);
    return x;
  }

  // Runs SLSQP from `x`. The result is a guess for Polish().
  VectorXd Search(const VectorXd& x) const {
    const int size = num_unknowns();
    nlopt::opt optimizer(nlopt::LD_SLSQP, size);
    std::vector<double> lower(size), upper(size), point(x.data(), x.data() + size);
    for (int i = 0; i < size; ++i) {
      const int cable = i - num_angles();
      lower[i] = cable < 0 ? std::min(-kLargestAngle, point[i]) : lower_[cable];
      upper[i] = cable < 0 ? std::max(kLargestAngle, point[i]) : upper_[cable];
    }
    optimizer.set_lower_bounds(lower);
    optimizer.set_upper_bounds(upper);
    auto* self = const_cast<StaticsProblem*>(this);
    optimizer.set_min_objective(&Objective, self);
    optimizer.add_equality_mconstraint(&Constraint, self, std::vector<double>(num_equations(), 1e-8));
    optimizer.set_ftol_rel(1e-9);
    optimizer.set_xtol_rel(1e-9);
    optimizer.set_maxeval(200);
    try {
      double norm = 0;
      optimizer.optimize(point, norm);
    } catch (const std::runtime_error&) {  // rounding errors, or a cable without length on the way
    }
    return Eigen::Map<const VectorXd>(point.data(), size);
  }

  // Newton's method on the optimality conditions, with an active set of tensions held at a bound. True if `x`
  // is then a solution and a minimum.
  bool Polish(VectorXd* x) const {
    const int n = robot_.num_cables();
    ActiveSet side(n);
    for (int i = 0; i < n; ++i) {
      const double u = (*x)[num_angles() + i];
      side[i] = u < lower_[i] + 1e-6 ? -1 : u > upper_[i] - 1e-6 ? 1 : 0;
    }
    for (int round = 0; round < 2 * n; ++round) {
      VectorXd gradient;
      if (!Converge(side, x, &gradient)) return false;
      // Adds the worst violated bound to the active set; if there is none, drops the one with the largest
      // multiplier of the wrong sign.
      int worst = -1, change = 0;
      double excess = kBoundTolerance;
      for (int i = 0; i < n; ++i) {
        const double u = (*x)[num_angles() + i];
        const double beyond = std::max(lower_[i] - u, u - upper_[i]);
        if (side[i] == 0 && beyond > excess) {
          excess = beyond;
          worst = i;
          change = u < lower_[i] ? -1 : 1;
        }
      }
      if (worst < 0) {
        for (int i = 0; i < n; ++i) {
          if (side[i] != 0 && side[i] * gradient[num_angles() + i] > excess) {
            excess = side[i] * gradient[num_angles() + i];
            worst = i;
          }
        }
      }
      if (worst < 0) {
        Clamp(x);
        return true;
      }
      side[worst] = change;
    }
    return false;
  }

 private:
  static double Objective(const std::vector<double>& x, std::vector<double>& gradient, void* data) {
    const std::size_t angles = static_cast<const StaticsProblem*>(data)->angles_.size();
    double sum = 0;
    for (std::size_t i = angles; i < x.size(); ++i) sum += x[i] * x[i] / 2;
    if (!gradient.empty()) {
      std::copy(x.begin(), x.end(), gradient.begin());
      std::fill_n(gradient.begin(), angles, 0.0);
    }
    return sum;
  }

  static void Constraint(unsigned count, double* result, unsigned size, const double* x, double* gradient,
                         void* data) {
    const auto* problem = static_cast<const StaticsProblem*>(data);
    MatrixXd jacobian;
    Eigen::Map<VectorXd>(result, count) = problem->Residual(Eigen::Map<const VectorXd>(x, size), &jacobian);
    if (!gradient) return;
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    Eigen::Map<RowMajor>(gradient, count, size) = jacobian;
  }

  void Clamp(VectorXd* x) const {
    auto u = x->tail(robot_.num_cables());
    u = u.cwiseMax(lower_).cwiseMin(upper_).eval();
  }

  // The Hessian of |u|^2 / 2 + multiplier . F: exact in the tensions, in which F is linear, and by central
  // differences of the exact Jacobian in the angles.
  MatrixXd CalcHessian(const VectorXd& x, const VectorXd& multiplier) const {
    constexpr double kStep = 1e-5;
    const int size = num_unknowns(), angles = num_angles();
    MatrixXd hessian = MatrixXd::Identity(size, size);
    for (int j = 0; j < angles; ++j) {
      MatrixXd ahead, behind;
      VectorXd moved = x;
      moved[j] = x[j] + kStep;
      Residual(moved, &ahead);
      moved[j] = x[j] - kStep;
      Residual(moved, &behind);
      hessian.col(j) = (ahead - behind).transpose() * multiplier / (2 * kStep);
    }
    hessian.topRightCorner(angles, size - angles) =
        hessian.bottomLeftCorner(size - angles, angles).transpose();
    return hessian;
  }

  // Newton's method with the tensions of `side` held at their bounds. `gradient` is that of the Lagrangian,
  // which is nonzero only in the held tensions.
  bool Converge(const ActiveSet& side, VectorXd* x, VectorXd* gradient) const {
    const int n = robot_.num_cables(), angles = num_angles(), equations = num_equations();
    std::vector<int> free(angles);
    std::iota(free.begin(), free.end(), 0);
    for (int i = 0; i < n; ++i) {
      if (side[i] == 0)
        free.push_back(angles + i);
      else
        (*x)[angles + i] = side[i] < 0 ? lower_[i] : upper_[i];
    }
    const int count = static_cast<int>(free.size());
    if (count < equations) return false;

    VectorXd multiplier;
    for (int iteration = 0; iteration < 25; ++iteration) {
      MatrixXd jacobian;
      const VectorXd residual = Residual(*x, &jacobian);
      const MatrixXd reduced = jacobian(Eigen::all, free);
      VectorXd objective = *x;
      objective.head(angles).setZero();
      if (iteration == 0) multiplier = SolveLeastSquaresBasic(reduced.transpose(), -objective(free));
      *gradient = objective + jacobian.transpose() * multiplier;

      VectorXd defect(count + equations);
      defect << (*gradient)(free), residual;
      const MatrixXd hessian = CalcHessian(*x, multiplier);
      MatrixXd kkt = MatrixXd::Zero(count + equations, count + equations);
      kkt.topLeftCorner(count, count) = hessian(free, free);
      kkt.topRightCorner(count, equations) = reduced.transpose();
      kkt.bottomLeftCorner(equations, count) = reduced;
      const double scale = 1 + multiplier.cwiseAbs().maxCoeff();
      if (defect.head(count).cwiseAbs().maxCoeff() < 1e-12 * scale && residual.cwiseAbs().maxCoeff() < 1e-13)
        return IsMinimum(kkt, count);
      VectorXd step = SolveLinear(kkt, -defect);
      if (!step.allFinite()) return false;
      const double turn = step.head(angles).norm();
      if (turn > kLargestNewtonStep) step *= kLargestNewtonStep / turn;
      for (int c = 0; c < count; ++c) (*x)[free[c]] += step[c];
      multiplier += step.tail(equations);
    }
    return false;
  }

  // Returns whether the Hessian is positive definite on the null space of the constraints.
  static bool IsMinimum(const MatrixXd& kkt, int count) {
    const Eigen::Index equations = kkt.cols() - count;
    if (count == equations) return true;
    const MatrixXd constraints = kkt.topRightCorner(count, equations);
    const MatrixXd Q = CalcRangeBasis(constraints).Q;
    const MatrixXd tangent = Q.rightCols(count - equations);
    const MatrixXd reduced = tangent.transpose() * kkt.topLeftCorner(count, count) * tangent;
    return Eigen::LLT<MatrixXd>(reduced).info() == Eigen::Success;
  }

  const CdprDescription& robot_;
  Eigen::Vector3d p_WB_;
  double weight_;
  CableVector lower_, upper_;
  double arm_ = 0;
  std::vector<int> angles_, equations_;  // of roll, pitch, yaw and of the wrench
};

[[noreturn]] void Refuse(const CdprDescription& robot, const Eigen::Vector3d& p, const std::string& reason) {
  throw ParameterError(fmt::format("Robot '{}' cannot rest with its CoM at ({:.4g}, {:.4g}, {:.4g}) m: {}{}",
                                   robot.name, p.x(), p.y(), p.z(), reason,
                                   reason.ends_with('.') ? "" : "."));
}

StaticEquilibrium MakeEquilibrium(const CdprDescription& robot, const Eigen::Vector3d& p_WB,
                                  const Eigen::Vector3d& euler, const CableVector& tension) {
  StaticEquilibrium equilibrium;
  equilibrium.p_WB = p_WB;
  equilibrium.euler = euler;
  equilibrium.R_WB = RotationFromEuler(euler);
  equilibrium.tension = tension;
  const CableKinematics cables = CalcCableKinematics(robot, p_WB, equilibrium.R_WB);
  equilibrium.length = cables.length;
  equilibrium.stiffness_min = CalcLockedStiffness(robot, cables, p_WB, equilibrium.R_WB, tension);
  return equilibrium;
}

// Cables that end in one point leave some angles without stiffness.
bool IsStable(const CdprDescription& robot, const StaticEquilibrium& equilibrium) {
  return equilibrium.stiffness_min > (robot.ends_in_one_point() ? -kLeastStiffness : kLeastStiffness);
}

// Returns the least-norm minimum found from the grid of starts, preferably a stable one. If cables have no
// direction at the level attitude, `obstacle` contains the reason.
std::optional<StaticEquilibrium> SearchAttitudes(const CdprDescription& robot, const Eigen::Vector3d& p_WB,
                                                 const StaticsProblem& problem, std::string* obstacle) {
  std::optional<StaticEquilibrium> best;
  for (int start = 0; start < 27; ++start) {
    // The digits of `start` to base 3 select the angles; start 0 is the level attitude.
    constexpr double kGrid[] = {0, kStartAngle, -kStartAngle};
    const Eigen::Vector3d euler(kGrid[start % 3], kGrid[start / 3 % 3], kGrid[start / 9]);
    VectorXd x;
    try {
      x = problem.Start(euler);
      if (problem.num_angles() < 3 && problem.Euler(x) != euler) continue;  // another start has this angle
      x = problem.Search(x);
      if (!problem.Polish(&x) || problem.Euler(x).cwiseAbs().maxCoeff() > kLargestAngle) continue;
    } catch (const RunError& error) {  // an attachment coincides with its anchor or touches its pulley
      if (start == 0) *obstacle = error.what();
      continue;
    }
    const StaticEquilibrium found = MakeEquilibrium(robot, p_WB, problem.Euler(x), problem.Tension(x));
    const bool stable = IsStable(robot, found), best_stable = best && IsStable(robot, *best);
    if (!best || (stable && !best_stable) ||
        (stable == best_stable && found.tension.norm() < best->tension.norm()))
      best = found;
  }
  return best;
}

void CheckRobot(const CdprDescription& robot, const StaticsOptions& options) {
  const auto require = [&robot](bool good, const std::string& what) {
    if (!good) throw ParameterError(fmt::format("Robot '{}' has no statics: {}.", robot.name, what));
  };
  const int n = robot.num_cables();
  require(n >= kMinCables, fmt::format("it has {} cables, fewer than {}", n, kMinCables));
  require(robot.mass > 0, fmt::format("its mass is {:g} kg", robot.mass));
  require(internal::Cholesky<3>(robot.inertia_B).positive(), "its inertia is not positive definite");
  const CableVector lower = robot.tension_min(), upper = robot.tension_max();
  for (int i = 0; i < n; ++i)
    require(lower[i] >= 0 && lower[i] < upper[i],
            fmt::format("the tension bounds [{:g}, {:g}] N of cable {} are empty or let it push", lower[i],
                        upper[i], i));
  const auto plane = PlaneOf(robot);
  require(n >= 3 || plane,
          "two cables hold a platform only in the vertical plane of their anchors; turn and move the axes so "
          "that the anchors have the same x or the same y, and the attachments have x or y 0, or add a third "
          "cable");
  const int enough = plane ? 3 : 6;
  require(
      !options.attitude || (n >= enough && !robot.ends_in_one_point()),
      fmt::format("an attitude is prescribed, which takes {} cables that do not all end in one point, and "
                  "it has {}; leave the attitude free",
                  enough, n));
  require(!options.warm_start || options.warm_start->tension.size() == n,
          fmt::format("the warm start has {} tensions for {} cables",
                      options.warm_start ? options.warm_start->tension.size() : 0, n));
}

}  // namespace

StaticEquilibrium SolveInverseGeometricoStatic(const CdprDescription& robot, const Eigen::Vector3d& p_WB,
                                               const StaticsOptions& options) {
  CheckRobot(robot, options);
  if (!p_WB.allFinite()) Refuse(robot, p_WB, "the position is not finite");
  if (const auto plane = PlaneOf(robot)) {
    const char axis = "xyz"[plane->normal];
    if (std::abs(p_WB[plane->normal] - plane->at) > kInPlane)
      Refuse(robot, p_WB, fmt::format("its cables move it in the plane {} = {:.4g} m only", axis, plane->at));
    Eigen::Vector3d euler = options.attitude.value_or(Eigen::Vector3d::Zero());
    euler[plane->normal] = 0;
    if (!euler.isZero(0)) Refuse(robot, p_WB, fmt::format("its cables turn it about {} only", axis));
  }
  const CableVector lower = robot.tension_min(), upper = robot.tension_max();
  const auto refuse_if_above = [&] {
    const auto z = [](const CableDescription& cable) { return cable.anchor_W.z(); };
    const double height = z(std::ranges::max(robot.cables, {}, z));
    const bool flat = std::max(p_WB.z(), height) - z(std::ranges::min(robot.cables, {}, z)) < kInPlane;
    if (!robot.on_table && robot.springs.empty() && p_WB.z() >= height)
      Refuse(robot, p_WB,
             fmt::format("it is not below the highest anchor, at z = {:.4g} m{}", height,
                         flat ? "; if it slides on a level table, set on_table: true" : ""));
  };

  if (options.attitude) {
    const Eigen::Matrix3d R_WB = RotationFromEuler(*options.attitude);
    CableKinematics cables;
    try {
      CalcCableKinematics(robot, p_WB, R_WB, &cables);
    } catch (const RunError& error) {
      Refuse(robot, p_WB, error.what());
    }
    const TensionDistribution found = DistributeTension(cables.structure, -PassiveWrench(robot, p_WB, R_WB),
                                                        lower, upper, options.tension_aim);
    if (!found.feasible) {
      refuse_if_above();
      Refuse(robot, p_WB, "at the prescribed attitude " + found.reason);
    }
    const StaticEquilibrium equilibrium = MakeEquilibrium(robot, p_WB, *options.attitude, found.tension);
    if (!IsStable(robot, equilibrium)) {
      Refuse(robot, p_WB,
             fmt::format("the prescribed attitude is unstable, its least stiffness is {:.3g} N/m",
                         equilibrium.stiffness_min));
    }
    return equilibrium;
  }

  const StaticsProblem problem(robot, p_WB, lower, upper);
  if (options.warm_start) {
    VectorXd x = problem.At(*options.warm_start);
    try {
      if (problem.Polish(&x)) {
        const StaticEquilibrium found = MakeEquilibrium(robot, p_WB, problem.Euler(x), problem.Tension(x));
        if (IsStable(robot, found)) return found;
      }
    } catch (const RunError&) {  // as in the search
    }
  }
  std::string obstacle;
  const std::optional<StaticEquilibrium> found = SearchAttitudes(robot, p_WB, problem, &obstacle);
  if (found && IsStable(robot, *found)) return *found;

  refuse_if_above();
  if (found)
    Refuse(
        robot, p_WB,
        fmt::format("its equilibria are unstable, the least stiffness is {:.3g} N/m{}", found->stiffness_min,
                    robot.ends_in_one_point() ? "; attach the cables above the CoM" : ""));
  if (!obstacle.empty()) Refuse(robot, p_WB, obstacle);
  // Finds the bound that prevents an equilibrium.
  const CableVector infinite = CableVector::Constant(robot.num_cables(), kInfinity);
  const StaticsProblem unbounded(robot, p_WB, -infinite, infinite);
  if (const std::optional<StaticEquilibrium> pushed = SearchAttitudes(robot, p_WB, unbounded, &obstacle)) {
    int worst = 0;
    const double excess = (pushed->tension - upper).cwiseMax(lower - pushed->tension).maxCoeff(&worst);
    if (excess > kLeastExcess) {
      Refuse(robot, p_WB,
             fmt::format("cable {} of {} would need {:.5g} N, outside its bounds [{:g}, {:g}] N", worst,
                         robot.num_cables(), pushed->tension[worst], lower[worst], upper[worst]));
    }
  }
  CdprDescription point_mass = robot;
  for (CableDescription& cable : point_mass.cables) cable.attachment_B.setZero();
  for (SpringDescription& spring : point_mass.springs) spring.attachment_B.setZero();
  point_mass.RemovePulleys();
  const Eigen::Matrix3d level = Eigen::Matrix3d::Identity();
  const CableKinematics cables = CalcCableKinematics(point_mass, p_WB, level);
  const TensionDistribution held =
      DistributeTension(cables.structure, -PassiveWrench(point_mass, p_WB, level), lower, upper);
  if (!held.feasible) Refuse(robot, p_WB, "torques aside, " + held.reason);
  Refuse(robot, p_WB,
         fmt::format("there is no equilibrium with roll, pitch and yaw within {:.0f} deg",
                     kLargestAngle * 180 / std::numbers::pi));
}

}  // namespace tenon
