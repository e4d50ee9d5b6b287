#include <tenon/controllers/cdpr/cdpr_mpc_solver.h>
#include <tenon/controllers/cdpr/cdpr_tracking_problem.h>
#include <tenon/controllers/optimization/slq.h>
#include <tenon/systems/analysis/lqr.h>
#include <tenon/systems/framework/block/system.h>

#include <fmt/core.h>

#include <variant>

namespace tenon {
namespace {

constexpr double kStiffer = 10;  // penalty of a distance that is not kept over the weight of the position

CentroidalState Diagonal(const CdprDescription& robot, const CdprMpcWeights& weights) {
  CentroidalState Q;
  const Eigen::Array3d radii = robot.inertia_B.diagonal().array() / robot.mass;  // L = diag(radii) w
  Q << weights.velocity, (weights.angular_velocity.array() / radii.square()).matrix(), weights.position,
      weights.attitude;
  return Q;
}

/// The state of `body`, the platform with the payload of `load`, at the path's reference `at`, balanced by
/// one Newton step from `shift`; `balanced` has the attitude and the tensions.
CentroidalState CalcReference(double time, const CdprReference& at, const LoadEstimate& load,
                              const CableVector& broken, const LoadedPlatform& body, ReferenceShift& shift,
                              BalancedReference& balanced) {
  balanced.Calc(at, load, broken, shift, time);
  return CentroidalStateOf(body, at.position, balanced.R_WB(), balanced.euler(), at.velocity,
                           EulerRateMatrix(at.euler) * at.euler_rate);
}

CdprClearance ClearanceOf(const CdprMpcParams& params) {
  const EquilibriumPath& path = *params.path;
  const double begin = path.path().start_time();
  const CdprReference at = path.At(begin);
  CableKinematics start;
  CalcCableKinematics(path.robot(), at.position, RotationFromEuler(at.euler), &start, path.anchors(), begin);
  return {path.robot(), params.clearance, params.cable_clearance, start};
}

template <class From, class To>
void CopyEntries(const From& from, To& to) {
  std::copy_n(from.data(), to.size(), to.data());
}

/// Calls make(n) with the number of cables n, as a constant for 4 and 8, for which the compiler unrolls
/// loops, and as Eigen::Dynamic for all other numbers.
template <class Make>
auto ForCables(int cables, const Make& make) {
  switch (cables) {
    case 4:
      return make(std::integral_constant<int, 4>());
    case 8:
      return make(std::integral_constant<int, 8>());
    default:
      return make(std::integral_constant<int, Eigen::Dynamic>());
  }
}

/// Returns the infinite-horizon cost to go of the model, linearised at rest at the start of the path and
/// discretised with `period` [s]. It is that of the motions that the cables govern; the tensions do not
/// change the others.
template <int n>
Eigen::Matrix<double, 12, 12> CostToGo(const EquilibriumPath& path, double period, const CdprMpcCost& cost) {
  using Problem = CdprTrackingProblem<n>;
  const CdprDescription robot = path.anchors().RobotAt(path.robot(), path.path().start_time());
  const int cables = robot.num_cables();
  const CdprReference rest = path.At(path.path().start_time());
  CentroidalState x = CentroidalState::Zero();
  x.segment<3>(6) = rest.position;
  x.tail<3>() = rest.euler;
  typename Problem::Input u(cables);
  CopyEntries(rest.tension, u);
  typename RungeKutta<Problem>::Tangent AB(12, 12 + cables);
  Problem problem(robot, 1);
  problem.SetPose(robot, rest.position, RotationFromEuler(rest.euler));
  RungeKutta<Problem>(12, cables).Linearize(problem, StepMethod::kRungeKutta4, 1, &period, &x, &u, &AB);
  const Eigen::MatrixXd A = AB.leftCols(12), B = AB.rightCols(cables), R = (period * cost.R).asDiagonal(),
                        Q = (period * cost.Q).asDiagonal();
  const std::vector<int> motions = MotionsOf(robot);
  if (motions.size() == 6) return SolveDiscreteRiccati(A, B, Q, R);
  std::vector<int> states = motions;
  for (const int motion : motions) states.push_back(6 + motion);
  Eigen::Matrix<double, 12, 12> S = Eigen::Matrix<double, 12, 12>::Zero();
  S(states, states) = SolveDiscreteRiccati(A(states, states), B(states, Eigen::all), Q(states, states), R);
  return S;
}

}  // namespace

void CdprMpcParams::Validate() const {
  Demand(path != nullptr, "no path given: make an EquilibriumPath and share it");
  Demand(num_steps >= 2, fmt::format("num_steps = {} must be at least 2", num_steps));
  const double periods = horizon / rate.period();
  Demand(std::abs(periods - std::round(periods)) < 1e-6,
         fmt::format("horizon = {} s is not a multiple of the period of {} s", horizon, rate.period()));
  Demand(std::round(periods) >= num_steps,
         fmt::format(
             "num_steps = {} exceeds the periods in horizon = {} s: a step is at least one period of {} s",
             num_steps, horizon, rate.period()));
  for (const auto& [name, given] : {std::pair{"weights.tension", &weights.tension},
                                    std::pair{"terminal_weights.tension", &terminal_weights.tension}})
    given->CheckSize(name, path->robot().num_cables(), "cables");
  for (int i = 0; i < path->robot().num_cables(); ++i)
    Demand(weights.tension[i] > 0,
           fmt::format("weights.tension = {} must be positive: the tensions would not be unique",
                       weights.tension[i]));
  CheckRanges(weights, "weights");
  CheckRanges(terminal_weights, "terminal_weights");
  Demand(std::isfinite(unheld_time) && unheld_time >= 0,
         fmt::format("unheld_time = {} s must be finite and not negative", unheld_time));
  static_cast<void>(CdprMpcSolver::Cost(*this, weights, terminal_weights));
}

std::vector<int> CdprMpcSolver::Steps(const CdprMpcParams& params) {
  const int total = static_cast<int>(std::lround(params.horizon / params.rate.period()));
  const int n = params.num_steps;
  // Finds the ratio r with 1 + r + ... + r^(n-1) = total by bisection.
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
  BalancedReference balanced(params.path->robot());
  CdprPlan plan;
  const CentroidalState start =
      CalcReference(0, params.path->At(0), {}, {}, {params.path->robot(), {}}, plan.shift, balanced);
  plan.reference_rate.setZero(n);
  plan.nodes.resize(params.num_steps + 1);
  const std::vector<int> steps = Steps(params);
  int periods = 0;
  const int distances = ClearanceOf(params).size();
  for (int k = 0; k <= params.num_steps; ++k) {
    CdprPlan::Node& node = plan.nodes[k];
    node.time = periods * params.rate.period();
    if (k < params.num_steps) periods += steps[k];
    node.x = start;
    node.u = balanced.tension();
    node.K.setZero(n, 12);
    node.multipliers.setZero(distances);
  }
  return plan;
}

CdprMpcCost CdprMpcSolver::Cost(const CdprMpcParams& params, const CdprMpcWeights& weights,
                                const CdprMpcWeights& terminal_weights) {
  const CdprDescription& robot = params.path->robot();
  CdprMpcCost cost;
  cost.Q = Diagonal(robot, weights);
  Demand(
      weights.position.maxCoeff() > 0 || ClearanceOf(params).size() == 0,
      "weights.position is 0, but clearance is kept: give a positive weight, with which its penalty scales");
  cost.R = CableVector::NullaryExpr(robot.num_cables(), [&](Eigen::Index i) { return weights.tension[i]; });
  if (params.terminal == TerminalCost::kRiccati) {
    cost.Q_f = ForCables(robot.num_cables(),
                         [&](auto n) { return CostToGo<n()>(*params.path, params.rate.period(), cost); });
  } else {
    cost.Q_f.diagonal() = Diagonal(robot, terminal_weights);
  }
  return cost;
}

namespace {

template <int n>
using SlqFor = Slq<CdprTrackingProblem<n>>;
using AnySlq = std::variant<SlqFor<4>, SlqFor<8>, SlqFor<Eigen::Dynamic>>;

AnySlq MakeSlq(const CdprMpcParams& params) {
  const CdprDescription& robot = params.path->robot();
  std::vector<double> steps;  // [s]
  for (const int step : CdprMpcSolver::Steps(params)) steps.push_back(step * params.rate.period());
  return ForCables(robot.num_cables(), [&](auto n) -> AnySlq {
    CdprTrackingProblem<n()> problem(robot, params.num_steps, ClearanceOf(params));
    if (params.path->anchors().any()) problem.SeparateNodes(params.num_steps + 1);
    return SlqFor<n()>(problem, steps, params.slq);
  });
}

}  // namespace

/// The solver, and the references at the nodes of the path that later calls reuse.
class CdprMpcSolver::Impl {
 public:
  explicit Impl(const CdprMpcParams& params)
      : path_(params.path),
        equilibrium_input_(params.equilibrium_input),
        period_(params.rate.period()),
        steps_(CdprMpcSolver::Steps(params)),
        balanced_(params.path->robot()),
        slq_(MakeSlq(params)) {
    const CdprReference at = path_->At(0);
    const CentroidalState x = CalcReference(0, at, {}, {}, {path_->robot(), {}}, first_shift_, balanced_);
    const CableVector& u = balanced_.tension();
    const Target target{0, x, u, u, u};
    targets_.assign(steps_.size() + 1, target);
    cache_.assign(1 + static_cast<std::size_t>(std::lround(params.horizon / period_)),
                  {-1, at, false, target});
  }

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
    const SlqReport report = std::visit(
        [&]<int n>(SlqFor<n>& slq) { return Improve<n>(slq, time - plan.start, x, load, body, cost, plan); },
        slq_);
    plan.start = time;
    if (!report.ok()) return report;  // the last policy stays in use, with the payload it was made for
    plan.payload = load.payload;
    if (equilibrium_input_)
      plan.reference_rate = (NodeAt(time, 1).at.tension - NodeAt(time, 0).at.tension) / period_;
    return report;
  }

 private:
  // Time, reference and bounds at a node of the horizon, see CdprTrackingProblem.
  struct Target {
    double time;
    CentroidalState x;
    CableVector u, lower, upper;
  };
  // The path's reference at a time. `target` always contains the bounds; if `has_target` is true, it also
  // contains x and u without a load and with all cables intact.
  struct PathNode {
    double time;
    CdprReference at;
    bool has_target;
    Target target;
  };

  // The node `index` periods after `time`, from the cache if an earlier call computed it. If `time` is a
  // multiple of the period, the node's time is rounded to one, so that it does not depend on the call.
  PathNode& NodeAt(double time, long index) {
    const long now = std::lround(time / period_);
    const bool multiple = std::abs(time - static_cast<double>(now) * period_) < 1e-6 * period_;
    const double at =
        multiple ? static_cast<double>(now + index) * period_ : time + static_cast<double>(index) * period_;
    PathNode& node = cache_[static_cast<std::size_t>(now + index) % cache_.size()];
    if (node.time != at) {
      node.time = node.target.time = at;
      node.has_target = false;
      path_->At(at, &node.at);
      SetBounds(node);
    }
    return node;
  }
  void SetBounds(PathNode& node) const {
    const CdprDescription& robot = path_->robot();
    for (int i = 0; i < robot.num_cables(); ++i) {
      const double reel = robot.winch.reel_damping * node.at.length_rate[i];
      node.target.lower[i] = std::max(reel + robot.tension_min(i), robot.tension_min(i));
      node.target.upper[i] = std::min(reel + robot.tension_max(i), robot.tension_max(i));
    }
  }

  // With a load, which changes from call to call, or with a broken cable, each node is balanced anew.
  // Newton's method starts at a node from the shift of the previous node, and at the first node from that of
  // the last call.
  void SetTargets(double time, const LoadEstimate& load, const CableVector& broken,
                  const LoadedPlatform& body, ReferenceShift& shift) {
    constexpr int kFirstSteps = 3;  // number of Newton steps at the first node
    const bool shifted = load.any() || (broken.array() != 0).any();
    shift.held = true;
    if (shifted)
      for (int i = 0; i + 1 < kFirstSteps; ++i) balanced_.Calc(NodeAt(time, 0).at, load, broken, shift, time);
    long index = 0;
    for (std::size_t k = 0; k < targets_.size(); ++k) {
      PathNode& node = NodeAt(time, index);
      if (shifted || !node.has_target) {
        node.target.x = CalcReference(node.time, node.at, load, broken, body, shift, balanced_);
        node.target.u = balanced_.tension();
        if (!equilibrium_input_) node.target.u.setZero();
        node.has_target = !shifted;
      }
      if (k == 0) first_shift_ = shift;
      Target& target = targets_[k] = node.target;
      for (Eigen::Index i = 0; i < broken.size(); ++i)
        if (broken[i] != 0) target.u[i] = target.lower[i] = target.upper[i] = 0;
      if (k < steps_.size()) index += steps_[k];
    }
    shift = first_shift_;
  }

  // Sets the anchors of all nodes, with pulleys at the reference of each node.
  template <int n>
  void SetAnchors(const LoadedPlatform& body, CdprTrackingProblem<n>& problem) const {
    for (std::size_t k = 0; k < targets_.size(); ++k) {
      const Target& target = targets_[k];
      const Eigen::Matrix3d R_WB = RotationFromEuler(target.x.tail<3>());
      problem.SetAnchors(static_cast<int>(k), path_->robot(), path_->anchors(), target.time,
                         target.x.segment<3>(6) - R_WB * body.com_B, R_WB);
    }
  }

  // Shifts `plan` by `elapsed` [s] and improves it for a start at x.
  template <int n>
  SlqReport Improve(SlqFor<n>& slq, double elapsed, const CentroidalState& x, const LoadEstimate& load,
                    const LoadedPlatform& body, const CdprMpcCost& cost, CdprPlan& plan) const {
    const CdprDescription& robot = path_->robot();
    auto& policy = slq.policy();
    for (std::size_t k = 0; k < policy.size(); ++k) {
      policy[k].x = plan.nodes[k].x;
      CopyEntries(plan.nodes[k].u, policy[k].u);
      CopyEntries(plan.nodes[k].K, policy[k].K);
    }
    if (elapsed > 0) slq.Shift(elapsed);
    CdprTrackingProblem<n>& problem = slq.problem();
    problem.SetPayload(robot, body);
    problem.com_B = body.com_B;
    problem.lagrangian.penalty = kStiffer * cost.Q.segment<3>(6).maxCoeff();
    for (std::size_t k = 0; k < policy.size() && problem.clearance.size() > 0; ++k) {
      const auto [i, share] = plan.Find(plan.nodes[k].time + elapsed);
      problem.multipliers[k] =
          (1 - share) * plan.nodes[i].multipliers + share * plan.nodes[i + 1].multipliers;
    }
    const Eigen::Matrix3d R_WB = RotationFromEuler(x.tail<3>());
    if (path_->anchors().any())
      SetAnchors(body, problem);
    else
      problem.SetPose(robot, x.segment<3>(6) - R_WB * body.com_B, R_WB);
    const Eigen::Vector3d com_W = RotationFromEuler(targets_.front().x.tail<3>()) * body.com_B;
    const Eigen::Vector3d force = load.rest.force_W, torque = load.rest.torque_W;
    problem.load << force, torque - com_W.cross(force);
    problem.Q = cost.Q;
    CopyEntries(cost.R, problem.R);
    problem.Q_f = cost.Q_f;
    problem.coupled = false;
    if (load.payload.mass != 0)
      problem.SetErrors(ErrorsOfPlatform(robot, body, targets_.front().x.tail<3>()));
    for (std::size_t k = 0; k < targets_.size(); ++k) {
      auto& target = problem.targets[k];
      target.x = targets_[k].x;
      CopyEntries(targets_[k].u, target.u);
      CopyEntries(targets_[k].lower, target.lower);
      CopyEntries(targets_[k].upper, target.upper);
    }
    const SlqReport report = slq.Solve(x);
    if (report.ok()) problem.UpdateMultipliers(policy);
    for (std::size_t k = 0; k < policy.size(); ++k) {
      plan.nodes[k].multipliers = problem.multipliers[k];
      plan.nodes[k].x = policy[k].x;
      CopyEntries(policy[k].u, plan.nodes[k].u);
      CopyEntries(policy[k].K, plan.nodes[k].K);
    }
    return report;
  }

  std::shared_ptr<const EquilibriumPath> path_;
  bool equilibrium_input_;
  double period_;
  std::vector<int> steps_;
  std::vector<Target> targets_;
  std::vector<PathNode> cache_;
  BalancedReference balanced_;
  ReferenceShift first_shift_;
  AnySlq slq_;
};

CdprMpcSolver::CdprMpcSolver(const CdprMpcParams& params) : impl_(std::make_unique<Impl>(params)) {}
CdprMpcSolver::CdprMpcSolver(const CdprMpcSolver& other) : impl_(std::make_unique<Impl>(*other.impl_)) {}
CdprMpcSolver& CdprMpcSolver::operator=(const CdprMpcSolver& other) {
  *impl_ = *other.impl_;
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
