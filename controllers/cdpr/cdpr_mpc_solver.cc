#include <tenon/controllers/cdpr/balanced_reference.h>
#include <tenon/controllers/cdpr/cdpr_mpc_solver.h>
#include <tenon/controllers/cdpr/cdpr_tracking_problem.h>
#include <tenon/controllers/cdpr/loaded_platform.h>
#include <tenon/controllers/optimization/riccati.h>
#include <tenon/controllers/optimization/slq.h>
#include <tenon/plants/signals/euler.h>
#include <tenon/systems/framework/block/system.h>

#include <Eigen/LU>
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <type_traits>

namespace tenon {
namespace internal {

/// The reference of the solver at a time.
struct SolverReference {
  CentroidalState x = CentroidalState::Zero();
  BalancedReference balanced;

  explicit SolverReference(const CdprDescription& robot) : balanced(robot) {}
};

}  // namespace internal

namespace {

using internal::SolverReference;

CentroidalState Diagonal(const CdprDescription& robot, const CdprMpcWeights& weights) {
  CentroidalState Q;
  const Eigen::Array3d radii = robot.inertia_B.diagonal().array() / robot.mass;  // L = diag(radii) w
  Q << Eigen::Vector3d::Constant(weights.velocity), (weights.angular_velocity / radii.square()).matrix(),
      Eigen::Vector3d::Constant(weights.position), Eigen::Vector3d::Constant(weights.attitude);
  return Q;
}

/// Of the path's reference `at`; `body` is the platform with the payload of `load`.
void CalcReference(const CdprReference& at, const LoadEstimate& load, const CableVector& broken,
                   const LoadedPlatform& body, ReferenceShift& shift, SolverReference* reference) {
  reference->balanced.Calc(at, load, broken, shift);
  reference->x = CentroidalStateOf(body, at.position, reference->balanced.R_WB(), reference->balanced.euler(),
                                   at.velocity, EulerRateMatrix(at.euler) * at.euler_rate);
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
  CentroidalState x = CentroidalState::Zero();
  x.segment<3>(6) = rest.position;
  x.tail<3>() = rest.euler;
  typename Problem::Input u(cables);
  CopyEntries(rest.tension, u);
  typename RungeKutta<Problem>::Tangent AB(12, 12 + cables);
  Problem problem(path.robot(), 1);
  problem.SetPose(path.robot(), rest.position, RotationFromEuler(rest.euler));
  RungeKutta<Problem>(12, cables).Linearize(problem, StepMethod::kRungeKutta4, 1, &period, &x, &u, &AB);
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
  for (const auto& [which, w] : {std::pair{"weights", weights}, {"terminal_weights", terminal_weights}}) {
    for (const auto& [name, weight] : {std::pair{"position", w.position},
                                       {"velocity", w.velocity},
                                       {"attitude", w.attitude},
                                       {"angular_velocity", w.angular_velocity}})
      Demand(weight >= 0 && std::isfinite(weight),
             fmt::format("{}.{} = {} must be finite and not negative: the optimal control problem would have "
                         "no minimum",
                         which, name, weight));
  }
  Demand(std::isfinite(unheld_time) && unheld_time >= 0,
         fmt::format("unheld_time = {} s must be finite and not negative", unheld_time));
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
  SolverReference start(params.path->robot());
  CdprPlan plan;
  CalcReference(params.path->At(0), {}, {}, {params.path->robot(), {}}, plan.shift, &start);
  plan.reference_rate.setZero(n);
  plan.nodes.resize(params.num_steps + 1);
  const std::vector<int> steps = Steps(params);
  int periods = 0;
  for (int k = 0; k <= params.num_steps; ++k) {
    CdprPlan::Node& node = plan.nodes[k];
    node.time = periods * params.rate.period();
    if (k < params.num_steps) periods += steps[k];
    node.x = start.x;
    node.u = start.balanced.tension();
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
        steps_(Steps(params)),
        reference_(params.path->robot()) {
    ReferenceShift none;
    const CdprReference at = path_->At(0);
    CalcReference(at, {}, {}, {path_->robot(), {}}, none, &reference_);
    const CableVector& u = reference_.balanced.tension();
    const Target target{reference_.x, u, u, u};
    targets_.assign(steps_.size() + 1, target);
    first_shift_ = none;
    cache_.assign(1 + static_cast<std::size_t>(std::lround(params.horizon / period_)),
                  {-1, at, false, target});
  }
  virtual ~Impl() = default;
  virtual std::unique_ptr<Impl> Clone() const = 0;

  void Follow(const std::shared_ptr<const EquilibriumPath>& path) {
    if (path == path_) return;
    path_ = path;
    for (PathNode& node : cache_) node.time = -1;
  }

  SlqReport Solve(double time, CentroidalState x, const LoadEstimate& load, const CableVector& broken,
                  const CdprMpcCost& cost, CdprPlan& plan) {
    const LoadedPlatform body(path_->robot(), load.payload);
    SetTargets(time, load, broken, body, plan.shift);
    plan.unheld_in_a_row = plan.shift.held ? 0 : plan.unheld_in_a_row + 1;
    x.tail<3>() = EulerNear(x.tail<3>(), targets_[0].x.tail<3>());
    const SlqReport report = Improve(time - plan.start, x, load, body, targets_, cost, plan);
    plan.start = time;
    if (!report.ok()) return report;  // the policy before goes on, about the CoM that it was made for
    plan.payload = load.payload;
    if (!equilibrium_input_) return report;  // whose tensions do not change
    plan.reference_rate = (NodeAt(time, 1).at.tension - NodeAt(time, 0).at.tension) / period_;
    return report;
  }

 protected:
  /// What CdprTrackingProblem knows of a node.
  struct Target {
    CentroidalState x;
    CableVector u, lower, upper;
  };

  /// `plan`, seen `elapsed` [s] later, becomes the one for a start at x.
  virtual SlqReport Improve(double elapsed, const CentroidalState& x, const LoadEstimate& load,
                            const LoadedPlatform& body, const std::vector<Target>& targets,
                            const CdprMpcCost& cost, CdprPlan& plan) = 0;

 private:
  // What the path says at a time, and what follows from it without a load.
  struct PathNode {
    double time;
    CdprReference at;
    bool has_target;
    Target target;
  };

  // The node `index` periods after `time`; what was computed for an earlier call is used again. If `time` is
  // a multiple of the period, so is the node's, whichever call comes first.
  PathNode& NodeAt(double time, long index) {
    const long now = std::lround(time / period_);
    const bool multiple = std::abs(time - static_cast<double>(now) * period_) < 1e-6 * period_;
    const double at =
        multiple ? static_cast<double>(now + index) * period_ : time + static_cast<double>(index) * period_;
    PathNode& node = cache_[static_cast<std::size_t>(now + index) % cache_.size()];
    if (node.time != at) {
      node.time = at;
      node.has_target = false;
      path_->At(at, &node.at);
    }
    return node;
  }

  // With a load, which changes, or a broken cable every node is balanced anew. What it shifts at one node is
  // where the next begins; the first one's is kept for the next call.
  void SetTargets(double time, const LoadEstimate& load, const CableVector& broken,
                  const LoadedPlatform& body, ReferenceShift& shift) {
    if (load.any() || (broken.array() != 0).any()) return SetShiftedTargets(time, load, broken, body, shift);
    shift.held = true;
    long index = 0;
    for (std::size_t k = 0; k < targets_.size(); ++k) {
      PathNode& node = NodeAt(time, index);
      if (!node.has_target) {
        CalcReference(node.at, load, broken, body, shift, &reference_);
        SetTarget(node.at, node.target);
        node.has_target = true;
      }
      targets_[k] = node.target;
      if (k < steps_.size()) index += steps_[k];
    }
  }
  void SetShiftedTargets(double time, const LoadEstimate& load, const CableVector& broken,
                         const LoadedPlatform& body, ReferenceShift& shift) {
    constexpr int kSteps = 3;  // of Newton's method at the first node
    const CdprReference& first = NodeAt(time, 0).at;
    for (int i = 0; i + 1 < kSteps; ++i) CalcReference(first, load, broken, body, shift, &reference_);
    long index = 0;
    for (std::size_t k = 0; k < targets_.size(); ++k) {
      const CdprReference& at = NodeAt(time, index).at;
      CalcReference(at, load, broken, body, shift, &reference_);
      SetTarget(at, targets_[k]);
      for (Eigen::Index i = 0; i < broken.size(); ++i)
        if (broken[i] != 0) targets_[k].u[i] = targets_[k].lower[i] = targets_[k].upper[i] = 0;
      if (k == 0) first_shift_ = shift;
      if (k < steps_.size()) index += steps_[k];
    }
    shift = first_shift_;
  }
  void SetTarget(const CdprReference& at, Target& target) const {
    const CdprDescription& robot = path_->robot();
    const CableProperties& cable = robot.cable;
    target.x = reference_.x;
    target.u = reference_.balanced.tension();
    for (int i = 0; i < robot.num_cables(); ++i) {
      const double reel = robot.winch.reel_damping * at.length_rate[i];
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
  std::vector<PathNode> cache_;
  // Work space.
  SolverReference reference_;
  ReferenceShift first_shift_;
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
        robot_(params.path->robot()),
        slq_(Problem(params.path->robot(), params.num_steps), StepsInSeconds(params), params.slq) {}
  std::unique_ptr<Impl> Clone() const override { return std::make_unique<SolverFor>(*this); }

 private:
  SlqReport Improve(double elapsed, const CentroidalState& x, const LoadEstimate& load,
                    const LoadedPlatform& body, const std::vector<Target>& targets, const CdprMpcCost& cost,
                    CdprPlan& plan) override {
    auto& policy = slq_.policy();
    for (std::size_t k = 0; k < policy.size(); ++k) {
      policy[k].x = plan.nodes[k].x;
      CopyEntries(plan.nodes[k].u, policy[k].u);
      CopyEntries(plan.nodes[k].K, policy[k].K);
    }
    if (elapsed > 0) slq_.Shift(elapsed);
    Problem& problem = slq_.problem();
    problem.SetPayload(robot_, body);
    const Eigen::Matrix3d R_WB = RotationFromEuler(x.tail<3>());
    problem.SetPose(robot_, x.segment<3>(6) - R_WB * body.com_B, R_WB);
    const Eigen::Vector3d com_W = RotationFromEuler(targets.front().x.tail<3>()) * body.com_B;
    const Eigen::Vector3d force = load.rest.force_W, torque = load.rest.torque_W;
    problem.load << force, torque - com_W.cross(force);
    problem.Q = cost.Q;
    problem.R.setConstant(cost.R);
    problem.Q_f = cost.Q_f;
    problem.coupled = false;
    if (load.payload.mass != 0)
      problem.SetErrors(ErrorsOfPlatform(robot_, body, targets.front().x.tail<3>()));
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

  CdprDescription robot_;
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

void CdprMpcSolver::Follow(const std::shared_ptr<const EquilibriumPath>& path) {
  impl_->Follow(path);
}

SlqReport CdprMpcSolver::Solve(double time, const CentroidalState& x, const LoadEstimate& load,
                               const CableVector& broken, const CdprMpcCost& cost, CdprPlan& plan) {
  return impl_->Solve(time, x, load, broken, cost, plan);
}

}  // namespace tenon
