#include <tenon/controllers/legged/planning/centroidal_mpc.h>
#include <tenon/controllers/legged/whole_body/whole_body_qp.h>
#include <tenon/controllers/optimization/slq.h>
#include <tenon/plants/model/vectors.h>
#include <tenon/systems/analysis/internal/small_matrices.h>

#include <fmt/core.h>

#include <chrono>

namespace tenon {
namespace {

using Problem = CentroidalWalkProblem;
constexpr int kFeet = 12;  // index of the feet in the state
constexpr int kAir = 0, kGround = 1, kLanding = 2;
constexpr double kSteadyTime = 0.5;  // time constant of the wrench's steady part [s]
constexpr double kLean = 0.15;  // largest distance of a standing robot's path from the centre of its feet [h]

int RoleOf(const Problem::Node& node, int leg) {
  return node.lands[leg] ? kLanding : node.stands[leg] > 0 ? kGround : kAir;
}

/// The planned stances of a leg from now on, in turn with its swings.
class LegCourse {
 public:
  LegCourse(const LegContact& leg, const GaitTiming& timing) : timing_(timing) {
    end_ = timing.cycle() > 0 ? leg.time_to_lift_off : kNever;
    if (!leg.stance() && timing.cycle() > 0) begin_ = leg.time_to_touchdown;
  }
  double begin() const { return begin_; }  ///< of the present or next stance; 0 if the leg stands [s]
  double end() const { return end_; }      ///< [s]
  void Next() {
    begin_ = end_ + timing_.swing;
    end_ = begin_ + timing_.leg_stance();
  }

 private:
  const GaitTiming& timing_;
  double begin_ = 0, end_ = 0;
};

/// The edges of a pyramid inside the friction cone, as columns with the normal component 1.
Eigen::Matrix<double, 3, 4> FrictionEdges(const Eigen::Vector3d& n, double friction) {
  const Eigen::Vector3d t = FirstTangent(n), s = n.cross(t);
  Eigen::Matrix<double, 3, 4> edges;
  edges << n + friction * t, n - friction * t, n + friction * s, n - friction * s;
  return edges;
}

/// The cubic from `value` with `rate` to rest at 0 within T, at time t.
struct Faded {
  Eigen::Vector3d value, rate;
};
Faded Fade(const Eigen::Vector3d& value, const Eigen::Vector3d& rate, double T, double t) {
  if (t >= T) return {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  const double s = t / T;
  return {(1 - s) * (1 - s) * ((1 + 2 * s) * value + t * rate),
          (1 - s) * (-6 * s / T * value + (1 - 3 * s) * rate)};
}

Eigen::Vector3d RotationVector(const Eigen::Matrix3d& R) {
  const Eigen::AngleAxisd turn(R);
  return turn.angle() * turn.axis();
}

}  // namespace

struct CentroidalWalkSolver::Impl {
  Slq<Problem> slq;
};

CentroidalWalkSolver::CentroidalWalkSolver(const CentroidalMpcProperties& mpc, double time_unit)
    : impl_(std::make_unique<Impl>(Impl{
          Slq<Problem>(Problem(mpc.num_steps),
                       std::vector<double>(static_cast<std::size_t>(mpc.num_steps), mpc.step / time_unit),
                       {.method = StepMethod::kMidpoint,
                        .max_iterations = mpc.max_iterations,
                        .tolerance = mpc.tolerance})})) {}
CentroidalWalkSolver::CentroidalWalkSolver(const CentroidalWalkSolver& other)
    : impl_(std::make_unique<Impl>(*other.impl_)) {}
CentroidalWalkSolver& CentroidalWalkSolver::operator=(const CentroidalWalkSolver& other) {
  *impl_ = *other.impl_;
  return *this;
}
CentroidalWalkSolver::~CentroidalWalkSolver() = default;

Problem& CentroidalWalkSolver::problem() {
  return impl_->slq.problem();
}
CentroidalWalkSolver::Policy CentroidalWalkSolver::policy(int k) {
  auto& node = impl_->slq.policy()[k];
  return {node.x, node.u, node.K};
}
SlqReport CentroidalWalkSolver::Solve(const Problem::State& x0, double first_step) {
  impl_->slq.SetFirstStep(first_step);
  return impl_->slq.Solve(x0);
}

void CentroidalMpcParams::Validate() const {
  const double periods = mpc.step / rate.period();
  Demand(periods > 0.5 && std::abs(periods - std::round(periods)) < 1e-6,
         fmt::format("step = {} s is not a multiple of the period of {} s", mpc.step, rate.period()));
  Demand(friction > 0, fmt::format("friction = {} must be positive", friction));
  CheckGravity(gravity);
  CheckRanges(mpc, "mpc");
}

CentroidalMpc::Memory CentroidalMpc::FirstMemory() const {
  Memory first;
  first.nodes.resize(static_cast<std::size_t>(params.mpc.num_steps));
  return first;
}

/// Sets which feet stand, and which land, at each node.
void CentroidalMpc::SetContacts(const ContactSchedule& schedule, double first_step,
                                const std::array<bool, kNumLegs>& fixed, Problem* problem) const {
  const int N = params.mpc.num_steps;
  const auto time_of = [&](int k) { return k == 0 ? 0 : first_step + (k - 1) * params.mpc.step; };
  for (int i = 0; i < kNumLegs; ++i) {
    for (Problem::Node& node : problem->nodes) {
      node.stands[i] = 0;
      node.lands[i] = false;
    }
    bool first = true;
    for (LegCourse course(schedule.legs[i], schedule.timing); course.begin() < time_of(N); course.Next()) {
      for (int k = 0; k < N; ++k) {
        const double from = std::max(course.begin(), time_of(k)), to = std::min(course.end(), time_of(k + 1));
        Problem::Node& node = problem->nodes[k];
        if (to > from) node.stands[i] += (to - from) / (time_of(k + 1) - time_of(k));
        const bool touchdown = course.begin() >= time_of(k) && course.begin() < time_of(k + 1);
        if (touchdown && k > 0 && !(first && fixed[i]))
          problem->nodes[static_cast<std::size_t>(k) - 1].lands[i] = true;
      }
      first = false;
    }
    for (Problem::Node& node : problem->nodes)
      if (node.lands[i]) node.stands[i] = 0;
  }
}

/// Follows the parts of the wrench and sets the loads of all nodes.
void CentroidalMpc::SetLoads(const WrenchEstimate& wrench, double first_step, Memory& memory,
                             Problem* problem) const {
  const CentroidalMpcProperties& mpc = params.mpc;
  const double weight = model_.mass() * model_.gravity(), moment = weight * stance.com_height;
  const double gain = -std::expm1(-params.rate.period() / kSteadyTime);
  const double most = mpc.steady_rate * params.rate.period() * weight;
  WrenchEstimate& steady = memory.steady;
  steady.force_W += Shortened<3>(gain * (wrench.force_W - steady.force_W), most);
  steady.torque_W += Shortened<3>(gain * (wrench.torque_W - steady.torque_W), most * stance.com_height);
  if (mpc.forecast == WrenchForecast::kSinusoid) {
    Vec<6> now;
    now << wrench.force_W / weight, wrench.torque_W / moment;
    memory.sinusoid.Update(now, params.rate.period());
  }
  double t = 0;
  for (Problem::Node& node : problem->nodes) {
    const double left = mpc.forecast == WrenchForecast::kDecaying ? std::exp(-t / mpc.decay) : 1;
    node.load << (steady.force_W + left * (wrench.force_W - steady.force_W)) / weight,
        (steady.torque_W + left * (wrench.torque_W - steady.torque_W)) / moment;
    if (mpc.forecast == WrenchForecast::kSinusoid) node.load = memory.sinusoid.After(t);
    if (mpc.forecast == WrenchForecast::kNone) node.load.setZero();
    t += &node == &problem->nodes.front() ? first_step : mpc.step;
  }
}

/// Sets the reference and the bounds of all nodes, whose loads are set.
void CentroidalMpc::SetReference(const BodyReference& body, const PlanarPath& path,
                                 const ContactSchedule& schedule, const GroundPlane& ground,
                                 const Eigen::Vector2d& origin, double first_step,
                                 const CentroidalMpcWeights& weights, Problem* problem) const {
  const CentroidalMpcProperties& mpc = params.mpc;
  const double h = stance.com_height;
  const double speed = std::sqrt(h * model_.gravity());
  const Eigen::Matrix3d R_now = RotationFromQuaternion(body.q_WB);
  const Eigen::Matrix3d inertia_B = stance.inertia_B / (model_.mass() * h * h);
  const double half_stance = schedule.timing.num_steps > 0 ? schedule.timing.leg_stance() / 2 : 0;
  problem->edges = FrictionEdges(ground.Normal(), params.friction);
  problem->Q.head<12>() << weights.position, weights.position, weights.height,
      Vec<3>::Constant(weights.velocity), Vec<3>::Constant(weights.attitude),
      Vec<3>::Constant(weights.angular_momentum);
  problem->Q_f = weights.final_ratio * problem->Q;
  problem->final_divergence = weights.final_divergence;
  const Eigen::Vector2d v_path = path.VelocityW();
  Eigen::Vector3d offset = Eigen::Vector3d::Zero(), offset_rate = body.com_velocity_W;
  offset.head<2>() = body.com_W.head<2>() - path.position_W;
  offset[2] = ground.slope.dot(offset.head<2>());
  offset_rate -= Eigen::Vector3d(v_path[0], v_path[1], ground.slope.dot(v_path));
  double t = 0;
  for (std::size_t k = 0; k < problem->nodes.size(); ++k) {
    Problem::Node& node = problem->nodes[k];
    const PlanarPath there = path.At(t);
    const Eigen::Vector2d v = there.VelocityW();
    const Eigen::Matrix3d R = Eigen::AngleAxisd(path.yaw_rate * t, Eigen::Vector3d::UnitZ()) * R_now;
    const Eigen::Matrix3d inertia_W = R * inertia_B * R.transpose();
    node.inverse_inertia = internal::Inverse<3>(inertia_W);
    node.turn << 0, 0, path.yaw_rate * time_unit_;
    node.heading = there.Heading();
    const Eigen::Vector3d on_path(there.position_W[0], there.position_W[1],
                                  body.com_W[2] + ground.slope.dot(there.position_W - body.com_W.head<2>()));
    const Eigen::Vector3d along_path(v[0], v[1], ground.slope.dot(v));
    const Faded off = Fade(offset, offset_rate, params.blend, t);
    node.x.setZero();
    node.x.head<3>() = (on_path + off.value) / h;
    node.x.head<2>() -= origin / h;
    node.x.segment<3>(3) = (along_path + off.rate) / speed;
    node.x.segment<3>(9) = inertia_W * node.turn;

    double standing = 0;
    for (const double s : node.stands) standing += s;
    const double lifted = std::clamp(1 - node.load[2], 0.2, 2.0);
    node.u.setZero();
    node.lower.setZero();
    node.upper.setZero();
    node.R.setConstant(weights.force);
    for (int i = 0; i < kNumLegs; ++i) {
      const int u = 4 * i;
      const Eigen::Vector2d nominal = FootprintOnSlope(ground.slope, there.yaw) * stance.foot[i];
      node.nominal[i] = (nominal + ground.ContactArm(params.robot.foot_radius).head<2>()) / h;
      node.height[i] = ground.HeightAt(there.position_W + nominal) / h;
      if (node.stands[i] > 0) {
        node.upper.segment<4>(u).setConstant(mpc.edge_force);
        node.u.segment<4>(u).setConstant(std::min(lifted / std::max(standing, 1.0) / 4, mpc.edge_force));
      } else if (node.lands[i]) {
        const double side = stance.foot[i][1], reach = stance.reach[i] / h;
        const double inward = std::min(reach, (1 - mpc.least_width) * std::abs(side) / h);
        node.upper.segment<2>(u) << reach, side > 0 ? reach : inward;
        node.lower.segment<2>(u) << -reach, side > 0 ? -inward : -reach;
        node.u.segment<2>(u) = (half_stance / h * there.velocity)
                                   .cwiseMax(node.lower.segment<2>(u))
                                   .cwiseMin(node.upper.segment<2>(u));
        if (!mpc.footholds) node.lower.segment<2>(u) = node.upper.segment<2>(u) = node.u.segment<2>(u);
        node.R.segment<2>(u).setConstant(weights.foothold);
      }
    }
    t += k == 0 ? first_step : mpc.step;
  }
}

/// Starts from the last policy where it is known and its inputs mean the same, else from the reference.
void CentroidalMpc::WarmStart(double time, long grid, const Eigen::Vector2d& origin, const Memory& memory,
                              CentroidalWalkSolver& solver) const {
  const int N = params.mpc.num_steps;
  const long passed = memory.started && grid >= memory.grid ? grid - memory.grid : N;
  Problem::State moved = Problem::State::Zero();  // of the origin
  moved.head<2>() = (origin - memory.origin) / stance.com_height;
  for (int leg = 0; leg < kNumLegs; ++leg) moved.segment<2>(kFeet + 2 * leg) = moved.head<2>();
  for (int k = 0; k <= N; ++k) {
    const Problem::Node& node = solver.problem().At(k);
    const CentroidalWalkSolver::Policy policy = solver.policy(k);
    policy.x = node.x;
    policy.u = node.u;
    policy.K.setZero();
    if (k + passed >= N) continue;
    const auto last = static_cast<std::size_t>(k + passed);
    const NodePolicy& before = memory.nodes[last];
    policy.x = before.x - moved;
    if (k == 0 && last + 1 < memory.nodes.size()) {  // the start has moved on between two nodes
      const double from = passed > 0 ? static_cast<double>(grid) * params.mpc.step : memory.start;
      const double share = (time - from) / (static_cast<double>(grid + 1) * params.mpc.step - from);
      policy.x += share * (memory.nodes[last + 1].x - before.x);
    }
    for (int i = 0; i < kNumLegs; ++i) {
      if (before.role[i] != RoleOf(node, i)) continue;
      policy.u.segment<4>(4 * i) = before.u.segment<4>(4 * i);
      policy.K.middleRows<4>(4 * i) = before.K.middleRows<4>(4 * i);
    }
  }
}

void CentroidalMpc::Keep(double time, long grid, const Eigen::Vector2d& origin, CentroidalWalkSolver& solver,
                         Memory& memory) const {
  memory.started = true;
  memory.start = time;
  memory.origin = origin;
  memory.grid = grid;
  for (std::size_t k = 0; k < memory.nodes.size(); ++k) {
    NodePolicy& node = memory.nodes[k];
    const CentroidalWalkSolver::Policy policy = solver.policy(static_cast<int>(k));
    node.x = policy.x;
    node.u = policy.u;
    node.K = policy.K;
    for (int i = 0; i < kNumLegs; ++i) node.role[i] = RoleOf(solver.problem().At(static_cast<int>(k)), i);
  }
}

void CentroidalMpc::CalcPlan(const double& time, const BodyReference& body, const PlanarPath& path,
                             const ContactSchedule& schedule, const LeggedState& state,
                             const GroundPlane& ground, const WrenchEstimate& wrench,
                             const WrenchEstimate& known_wrench, const CentroidalMpcWeights& weights,
                             Memory& memory, CentroidalWalkSolver& solver, CentroidalPlan* plan) const {
  const auto begin = std::chrono::steady_clock::now();
  const CentroidalMpcProperties& mpc = params.mpc;
  const int N = mpc.num_steps;
  const double h = stance.com_height, weight = model_.mass() * model_.gravity();
  const double speed = std::sqrt(h * model_.gravity());
  QuadrupedDynamics dynamics;
  model_.Calc(state, &dynamics);
  const Eigen::Vector2d origin = dynamics.com_W.head<2>();
  const WrenchEstimate total{wrench.force_W + known_wrench.force_W, wrench.torque_W + known_wrench.torque_W};

  constexpr double kRounding = 1e-6;
  const long grid = std::lround(std::floor(time / mpc.step + kRounding));
  const double first_step = static_cast<double>(grid + 1) * mpc.step - time;
  std::array<bool, kNumLegs> fixed{};
  for (int i = 0; i < kNumLegs; ++i) {
    const LegContact& leg = schedule.legs[i];
    fixed[i] = leg.state != ContactState::kSwing || leg.phase > params.retarget_phase;
  }
  Problem& problem = solver.problem();
  SetContacts(schedule, first_step, fixed, &problem);
  SetLoads(total, first_step, memory, &problem);
  // The feet of a robot that stands do not follow it to its path.
  PlanarPath reachable = path;
  BodyReference above = body;
  if (schedule.timing.num_steps == 0) {
    Eigen::Vector2d centre = Eigen::Vector2d::Zero();
    for (const auto& foot : dynamics.feet) centre += foot.p_W.head<2>() / kNumLegs;
    reachable.position_W = centre + Shortened<2>(path.position_W - centre, kLean * h);
    const Eigen::Vector2d moved = reachable.position_W - path.position_W;
    above.com_W += Eigen::Vector3d(moved[0], moved[1], ground.slope.dot(moved));
  }
  SetReference(above, reachable, schedule, ground, origin, first_step, weights, &problem);

  Problem::State x0;
  const Eigen::Matrix3d R_ref = RotationFromQuaternion(body.q_WB);
  // Without that of the swinging legs, whose motion the plan does not contain.
  const Eigen::Vector3d angular_momentum = dynamics.centroidal_inertia_W * state.w_W;
  x0.head<3>() << 0, 0, dynamics.com_W[2] / h;
  x0.segment<3>(3) = dynamics.com_velocity_W / speed;
  x0.segment<3>(6) = RotationVector(state.R_WB() * R_ref.transpose());
  x0.segment<3>(9) = angular_momentum / (model_.mass() * h * speed);
  const Eigen::Vector3d arm = ground.ContactArm(params.robot.foot_radius);
  for (int i = 0; i < kNumLegs; ++i) {
    const bool stands = schedule.legs[i].stance();
    const Eigen::Vector3d contact = dynamics.feet[i].p_W + arm;
    if (stands || !memory.started) memory.footholds.position_W[i] = dynamics.feet[i].p_W.head<2>();
    if (stands) {
      const double until = schedule.timing.num_steps == 0 ? kNever : schedule.legs[i].time_to_lift_off;
      double t = 0;
      for (int k = 0; k < N && t < until; t += k++ == 0 ? first_step : mpc.step)
        problem.nodes[k].height[i] = contact[2] / h;
    }
    x0.segment<2>(kFeet + 2 * i) = (memory.footholds.position_W[i] + arm.head<2>() - origin) / h;
  }

  WarmStart(time, grid, origin, memory, solver);
  const SlqReport report = solver.Solve(x0, first_step / time_unit_);

  CentroidalMpcDiagnostics& diagnostics = memory.diagnostics;
  ++diagnostics.solves;
  diagnostics.failures += !report.ok();
  diagnostics.failures_in_a_row = report.ok() ? 0 : diagnostics.failures_in_a_row + 1;
  if (report.ok()) diagnostics.cost = report.cost;
  Keep(time, grid, origin, solver, memory);
  // The foothold of each swinging foot's next landing.
  for (int i = 0; i < kNumLegs; ++i) {
    if (fixed[i] || !report.ok()) continue;
    for (int k = 0; k < N; ++k) {
      if (!problem.At(k).lands[i]) continue;
      memory.footholds.position_W[i] =
          origin + h * solver.policy(k + 1).x.segment<2>(kFeet + 2 * i) - arm.head<2>();
      break;
    }
  }
  memory.footholds.planned = mpc.footholds;

  // The mean acceleration of the first step, and those by the single feet.
  const Problem::Input& u = solver.policy(0).u;
  const Problem::Node& node = problem.At(0);
  const double angular_unit = 1 / (time_unit_ * time_unit_);
  const auto accelerations = [&](const Eigen::Vector3d& f, const Eigen::Vector3d& tau) {
    Vec<6> both;
    both << model_.gravity() * f, angular_unit * (node.inverse_inertia * tau);
    return both;
  };
  plan->free_fall = accelerations(node.load.head<3>() - Eigen::Vector3d::UnitZ(), node.load.tail<3>());
  Vec<6> mean = plan->free_fall;
  const Eigen::Vector3d middle = x0.head<3>() + first_step / time_unit_ / 2 * x0.segment<3>(3);
  for (int leg = 0; leg < kNumLegs; ++leg) {
    plan->push[leg].setZero();
    plan->force_W[leg].setZero();
    if (node.stands[leg] == 0) continue;
    const Eigen::Vector3d f = problem.edges * u.segment<4>(4 * leg);
    const Eigen::Vector3d r(x0[kFeet + 2 * leg], x0[kFeet + 2 * leg + 1], node.height[leg]);
    plan->force_W[leg] = weight * f;
    plan->push[leg] = accelerations(f, (r - middle).cross(f));
    mean += node.stands[leg] * plan->push[leg];
  }
  plan->start = time;
  plan->body.com_W = dynamics.com_W;
  plan->body.com_velocity_W = dynamics.com_velocity_W;
  plan->body.com_acceleration_W = mean.head<3>();
  plan->body.q_WB = state.q_WB;
  plan->body.w_W = state.w_W;
  plan->body.alpha_W = mean.tail<3>();
  plan->wrench = total;
  plan->footholds = memory.footholds;
  plan->diagnostics = diagnostics;
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin;
  plan->diagnostics.solve_time = elapsed.count();
}

BodyReference CentroidalMpc::CalcReference(const double& time, const CentroidalPlan& plan,
                                           const ContactSchedule& schedule) const {
  const double t = time - plan.start;
  BodyReference reference = plan.body;
  reference.com_W += t * (reference.com_velocity_W + t / 2 * reference.com_acceleration_W);
  reference.com_velocity_W += t * reference.com_acceleration_W;
  reference.q_WB = QuaternionProduct(
      QuaternionFromRotationVector(t * (reference.w_W + t / 2 * reference.alpha_W)), reference.q_WB);
  reference.w_W += t * reference.alpha_W;
  Vec<6> acceleration = plan.free_fall;
  for (int i = 0; i < kNumLegs; ++i)
    if (schedule.legs[i].stance()) acceleration += plan.push[i];
  reference.com_acceleration_W = acceleration.head<3>();
  reference.alpha_W = acceleration.tail<3>();
  return reference;
}

}  // namespace tenon

TENON_DEFINE_SIGNAL(tenon::FootholdPlan);
TENON_DEFINE_SIGNAL(tenon::CentroidalPlan);
TENON_DEFINE_SIGNAL(tenon::CentroidalMpcDiagnostics);
