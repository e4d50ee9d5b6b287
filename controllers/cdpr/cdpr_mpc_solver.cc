#include <tenon/controllers/cdpr/cdpr_mpc_solver.h>

#include <fmt/core.h>
#include <tenon/controllers/cdpr/cdpr_tracking_problem.h>
#include <tenon/controllers/optimization/riccati.h>
#include <tenon/controllers/optimization/slq.h>
#include <tenon/plants/model/euler.h>
#include <tenon/systems/framework/system.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <type_traits>

namespace tenon {
namespace {

constexpr double kTurnScale = 1e-3;  // a turn of so many rad counts as much as 1 N in the reference

CentroidalState Diagonal(const CdprDescription& robot, const CdprMpcWeights& weights) {
  CentroidalState Q;
  const Eigen::Array3d radii = robot.inertia_B.diagonal().array() / robot.mass;  // L = diag(radii) w
  Q << Eigen::Vector3d::Constant(weights.velocity), (weights.angular_velocity / radii.square()).matrix(),
      Eigen::Vector3d::Constant(weights.position), Eigen::Vector3d::Constant(weights.attitude);
  return Q;
}

/// The reference of the solver at a time, with what it is made from.
struct Reference {
  CentroidalState x = CentroidalState::Zero();
  CableVector u;  ///< [N]
  CdprReference at;
  CableKinematics cables;
};

void CalcReference(const EquilibriumPath& path, double time, Reference* reference) {
  const CdprDescription& robot = path.robot();
  CdprReference& at = reference->at;
  CableKinematics& cables = reference->cables;
  path.At(time, &at);
  const Eigen::Matrix3d R_WB = RotationFromEuler(at.euler), E = EulerRateMatrix(at.euler);
  CalcCableKinematics(robot, at.position, R_WB, &cables);

  const Eigen::Matrix<double, 6, 3> by_turn =
      kTurnScale * CalcWrenchJacobian(cables, at.tension).rightCols<3>();
  Vector6d inertial = Vector6d::Zero();
  inertial.head<3>() = robot.mass * at.acceleration;
  Matrix6d gram;
  gram.noalias() = by_turn * by_turn.transpose();
  for (int i = 0; i < robot.num_cables(); ++i)
    gram.noalias() += cables.structure.col(i) * cables.structure.col(i).transpose();
  const Vector6d multiplier = gram.ldlt().solve(inertial);
  const Eigen::Vector3d turn = kTurnScale * (by_turn.transpose() * multiplier);

  const Eigen::Vector3d w = E * at.euler_rate;
  reference->x << at.velocity, R_WB * robot.inertia_B * R_WB.transpose() * w / robot.mass, at.position,
      at.euler + E.inverse() * turn;
  reference->u = at.tension;
  reference->u.noalias() += cables.structure.transpose() * multiplier;
}

template <class From, class To>
void CopyEntries(const From& from, To& to) {
  std::copy_n(from.data(), to.size(), to.data());
}

/// What `make` gives for a number of cables, which the compiler knows for small robots, whose loops it
/// unrolls.
template <class Make>
auto ForCables(int cables, const Make& make) {
  switch (cables) {
    case 4:
      return make(std::integral_constant<int, 4>());
    case 5:
      return make(std::integral_constant<int, 5>());
    case 6:
      return make(std::integral_constant<int, 6>());
    case 7:
      return make(std::integral_constant<int, 7>());
    case 8:
      return make(std::integral_constant<int, 8>());
    default:
      return make(std::integral_constant<int, Eigen::Dynamic>());
  }
}

/// At rest at the start of the path, of the problem that is linear there: at these costs, for ever.
template <int n>
Eigen::Matrix<double, 12, 12> CostToGo(const EquilibriumPath& path, double period, const CdprMpcCost& cost) {
  using Problem = CdprTrackingProblem<n>;
  const int cables = path.robot().num_cables();
  const CdprReference rest = path.At(path.path().start_time());
  CentroidalState x = CentroidalState::Zero(), next;
  x.segment<3>(6) = rest.position;
  x.tail<3>() = rest.euler;
  typename Problem::Input u(cables);
  CopyEntries(rest.tension, u);
  typename RungeKutta<Problem>::Tangent AB(12, 12 + cables);
  RungeKutta<Problem>(12, cables)
      .Step(Problem(path.robot(), 1), StepMethod::kRungeKutta4, period, x, u, next, AB);
  const Eigen::VectorXd R = Eigen::VectorXd::Constant(cables, period * cost.R);
  return SolveDiscreteRiccati(AB.leftCols(12), AB.rightCols(cables),
                              Eigen::MatrixXd((period * cost.Q).asDiagonal()),
                              Eigen::MatrixXd(R.asDiagonal()));
}

}  // namespace

void CdprMpcParams::Validate() const {
  Demand(path != nullptr, "no path given: make an EquilibriumPath and share it");
  Demand(num_steps >= 2, fmt::format("num_steps = {} must be at least 2", num_steps));
  const double periods = horizon / rate.period();
  Demand(std::abs(periods - std::round(periods)) < 1e-6,
         fmt::format("horizon = {} s is no multiple of the period of {} s", horizon, rate.period()));
  Demand(std::round(periods) >= num_steps,
         fmt::format("num_steps = {} do not fit into horizon = {} s: a step is at least one period of {} s",
                     num_steps, horizon, rate.period()));
  Demand(weights.tension > 0,
         fmt::format("weights.tension = {} must be positive: the tensions would not be unique",
                     weights.tension));
  for (const CdprMpcWeights& w : {weights, terminal_weights}) {
    Demand(std::min({w.position, w.velocity, w.attitude, w.angular_velocity}) >= 0,
           "a weight is negative: the optimal control problem would have no minimum");
  }
  Demand(max_fallbacks_in_a_row >= 0,
         fmt::format("max_fallbacks_in_a_row = {} must not be negative: every solve would end the run",
                     max_fallbacks_in_a_row));
  static_cast<void>(CdprMpcSolver::Cost(*this, weights, terminal_weights));
}

std::vector<int> CdprMpcSolver::Steps(const CdprMpcParams& params) {
  const int total = static_cast<int>(std::lround(params.horizon / params.rate.period()));
  const int n = params.num_steps;
  // The ratio with 1 + r + ... + r^(n-1) = total, by bisection.
  double low = 1, high = total;
  for (int i = 0; i < 100; ++i) {
    const double r = (low + high) / 2;
    double sum = 0;
    for (int k = 0; k < n && sum <= total; ++k) sum = 1 + r * sum;
    (sum < total ? low : high) = r;
  }
  std::vector<int> steps(n);
  double end = 0, step = 1;
  int last = 0;
  for (int k = 0; k < n; ++k, step *= low) {
    end += step;
    const int node = k + 1 == n ? total : std::max(last + 1, static_cast<int>(std::lround(end)));
    steps[k] = node - last;
    last = node;
  }
  return steps;
}

CdprPlan CdprMpcSolver::FirstPlan(const CdprMpcParams& params) {
  const int n = params.path->robot().num_cables();
  Reference start;
  CalcReference(*params.path, 0, &start);
  CdprPlan plan;
  plan.nodes.resize(params.num_steps + 1);
  const std::vector<int> steps = Steps(params);
  int periods = 0;
  for (int k = 0; k <= params.num_steps; ++k) {
    CdprPlan::Node& node = plan.nodes[k];
    node.time = periods * params.rate.period();
    if (k < params.num_steps) periods += steps[k];
    node.x = start.x;
    node.u = start.u;
    node.K.setZero(n, 12);
  }
  return plan;
}

CdprMpcCost CdprMpcSolver::Cost(const CdprMpcParams& params, const CdprMpcWeights& weights,
                                const CdprMpcWeights& terminal_weights) {
  const CdprDescription& robot = params.path->robot();
  CdprMpcCost cost;
  cost.Q = Diagonal(robot, weights);
  cost.R = weights.tension;
  if (params.terminal == TerminalCost::kRiccati) {
    cost.Q_f = ForCables(robot.num_cables(),
                         [&](auto n) { return CostToGo<n()>(*params.path, params.rate.period(), cost); });
  } else {
    cost.Q_f.diagonal() = Diagonal(robot, terminal_weights);
  }
  return cost;
}

/// Everything that is not compiled for a number of cables.
class CdprMpcSolver::Impl {
 public:
  explicit Impl(const CdprMpcParams& params)
      : path_(params.path),
        equilibrium_input_(params.equilibrium_input),
        period_(params.rate.period()),
        steps_(Steps(params)) {
    CalcReference(*path_, 0, &reference_);
    const Target target{reference_.x, reference_.u, reference_.u, reference_.u};
    targets_.assign(steps_.size() + 1, target);
    cache_.assign(1 + static_cast<std::size_t>(std::lround(params.horizon / period_)), {-1, target});
  }
  virtual ~Impl() = default;
  virtual std::unique_ptr<Impl> Clone() const = 0;

  SlqReport Solve(double time, CentroidalState x, const CdprMpcCost& cost, CdprPlan& plan) {
    SetTargets(time);
    // The angles next to those of the reference.
    for (int i = 9; i < 12; ++i) {
      constexpr double kTurn = 2 * std::numbers::pi;
      x[i] -= kTurn * std::round((x[i] - targets_[0].x[i]) / kTurn);
    }
    const SlqReport report = Improve(time - plan.start, x, targets_, cost, plan);
    plan.start = time;
    return report;
  }

 protected:
  /// What CdprTrackingProblem knows of a node.
  struct Target {
    CentroidalState x;
    CableVector u, lower, upper;
  };

  /// `plan`, seen `elapsed` [s] later, becomes the one for a start at x.
  virtual SlqReport Improve(double elapsed, const CentroidalState& x, const std::vector<Target>& targets,
                            const CdprMpcCost& cost, CdprPlan& plan) = 0;

 private:
  // A node is at a multiple of the period after `time`; what was computed for an earlier call is used again.
  void SetTargets(double time) {
    const long now = std::lround(time / period_);
    long index = 0;
    for (std::size_t k = 0; k < targets_.size(); ++k) {
      Cached& cached = cache_[static_cast<std::size_t>(now + index) % cache_.size()];
      if (cached.time != time + index * period_) {
        cached.time = time + index * period_;
        CalcReference(*path_, cached.time, &reference_);
        SetTarget(reference_, cached.target);
      }
      targets_[k] = cached.target;
      if (k < steps_.size()) index += steps_[k];
    }
  }
  void SetTarget(const Reference& reference, Target& target) const {
    const CdprDescription& robot = path_->robot();
    const CableProperties& cable = robot.cable;
    target.x = reference.x;
    target.u = reference.u;
    for (int i = 0; i < robot.num_cables(); ++i) {
      const double reel = robot.winch.reel_damping * reference.at.length_rate[i];
      target.lower[i] = std::max(reel + cable.tension_min, cable.tension_min);
      target.upper[i] = std::min(reel + cable.tension_max, cable.tension_max);
    }
    if (!equilibrium_input_) target.u.setZero();
  }

  std::shared_ptr<const EquilibriumPath> path_;
  bool equilibrium_input_;
  double period_;
  std::vector<int> steps_;
  std::vector<Target> targets_;
  struct Cached {
    double time = -1;
    Target target;
  };
  std::vector<Cached> cache_;
  Reference reference_;  // work space
};

namespace {

std::vector<double> StepsInSeconds(const CdprMpcParams& params) {
  std::vector<double> seconds;
  for (const int step : CdprMpcSolver::Steps(params)) seconds.push_back(step * params.rate.period());
  return seconds;
}

/// The solver for n cables, or for any number.
template <int n>
class SolverFor final : public CdprMpcSolver::Impl {
 public:
  using Problem = CdprTrackingProblem<n>;

  explicit SolverFor(const CdprMpcParams& params)
      : Impl(params),
        slq_(Problem(params.path->robot(), params.num_steps), StepsInSeconds(params), params.slq) {}
  std::unique_ptr<Impl> Clone() const override { return std::make_unique<SolverFor>(*this); }

 private:
  SlqReport Improve(double elapsed, const CentroidalState& x, const std::vector<Target>& targets,
                    const CdprMpcCost& cost, CdprPlan& plan) override {
    auto& policy = slq_.policy();
    for (std::size_t k = 0; k < policy.size(); ++k) {
      policy[k].x = plan.nodes[k].x;
      CopyEntries(plan.nodes[k].u, policy[k].u);
      CopyEntries(plan.nodes[k].K, policy[k].K);
    }
    if (elapsed > 0) slq_.Shift(elapsed);
    Problem& problem = slq_.problem();
    problem.Q = cost.Q;
    problem.R.setConstant(cost.R);
    problem.Q_f = cost.Q_f;
    for (std::size_t k = 0; k < targets.size(); ++k) {
      auto& target = problem.targets[k];
      target.x = targets[k].x;
      CopyEntries(targets[k].u, target.u);
      CopyEntries(targets[k].lower, target.lower);
      CopyEntries(targets[k].upper, target.upper);
    }
    const SlqReport report = slq_.Solve(x);
    for (std::size_t k = 0; k < policy.size(); ++k) {
      plan.nodes[k].x = policy[k].x;
      CopyEntries(policy[k].u, plan.nodes[k].u);
      CopyEntries(policy[k].K, plan.nodes[k].K);
    }
    return report;
  }

  Slq<Problem> slq_;
};

std::unique_ptr<CdprMpcSolver::Impl> MakeSolver(const CdprMpcParams& params) {
  return ForCables(params.path->robot().num_cables(), [&](auto n) -> std::unique_ptr<CdprMpcSolver::Impl> {
    return std::make_unique<SolverFor<n()>>(params);
  });
}

}  // namespace

CdprMpcSolver::CdprMpcSolver(const CdprMpcParams& params) : impl_(MakeSolver(params)) {}
CdprMpcSolver::CdprMpcSolver(const CdprMpcSolver& other) : impl_(other.impl_->Clone()) {}
CdprMpcSolver& CdprMpcSolver::operator=(const CdprMpcSolver& other) {
  if (this != &other) impl_ = other.impl_->Clone();
  return *this;
}
CdprMpcSolver::~CdprMpcSolver() = default;

SlqReport CdprMpcSolver::Solve(double time, const CentroidalState& x, const CdprMpcCost& cost,
                               CdprPlan& plan) {
  return impl_->Solve(time, x, cost, plan);
}

}  // namespace tenon
