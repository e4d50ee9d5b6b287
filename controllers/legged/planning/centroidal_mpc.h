#pragma once

#include <tenon/controllers/legged/planning/centroidal_walk_problem.h>
#include <tenon/controllers/legged/planning/foothold_plan.h>
#include <tenon/controllers/legged/planning/nominal_stance.h>
#include <tenon/controllers/legged/planning/wrench_sinusoid.h>
#include <tenon/plants/model/quadruped_model.h>
#include <tenon/plants/signals/disturbance_signals.h>
#include <tenon/plants/signals/gait_signals.h>
#include <tenon/plants/signals/motion_signals.h>
#include <tenon/systems/block.h>

namespace tenon {

/// How the estimated wrench continues over the horizon of CentroidalMpc.
enum class WrenchForecast {
  kNone,      ///< it does not: the plan knows of no wrench
  kHeld,      ///< it stays as it is
  kDecaying,  ///< it decays exponentially to its steady part
  kSinusoid,  ///< it goes on as the sinusoid that it has been, see WrenchSinusoid
};

/// Weights of CentroidalMpc, in the units of CentroidalWalkProblem: of squared errors, per sqrt(h / g) of the
/// horizon.
struct CentroidalMpcWeights {
  double position = 10;          ///< weight of the horizontal error of the CoM
  double height = 30;            ///< weight of the vertical error of the CoM
  double velocity = 2;           ///< weight of the error of the CoM's velocity
  double attitude = 4;           ///< weight of the error of the attitude [1/rad^2]
  double angular_momentum = 10;  ///< weight of the error of the angular momentum
  double force = 1;              ///< weight of the force along each edge of a friction pyramid
  double foothold = 20;          ///< weight of the displacement of a foothold
  double final_ratio = 3;        ///< weights of the final state, over those along the horizon
  double final_divergence = 10;  ///< weight of the final error of position plus velocity, horizontally

  static FieldList Fields() {
    return {Field("position", &CentroidalMpcWeights::position).AtLeast(0),
            Field("height", &CentroidalMpcWeights::height).AtLeast(0),
            Field("velocity", &CentroidalMpcWeights::velocity).AtLeast(0),
            Field("attitude", &CentroidalMpcWeights::attitude).AtLeast(0),
            Field("angular_momentum", &CentroidalMpcWeights::angular_momentum).AtLeast(0),
            Field("force", &CentroidalMpcWeights::force).Positive().Because("forces would not be unique"),
            Field("foothold", &CentroidalMpcWeights::foothold)
                .Positive()
                .Because("footholds would not be unique"),
            Field("final_ratio", &CentroidalMpcWeights::final_ratio).AtLeast(0),
            Field("final_divergence", &CentroidalMpcWeights::final_divergence).AtLeast(0)};
  }
};

/// Settings of CentroidalMpc.
struct CentroidalMpcProperties {
  int num_steps = 20;  ///< steps of the horizon
  double step = 0.03;  ///< length of a step, a multiple of the period [s]
  CentroidalMpcWeights weights = {};
  WrenchForecast forecast = WrenchForecast::kDecaying;  ///< the estimated wrench over the horizon
  double decay = 0.1;                                   ///< time constant of the forecast `decaying` [s]
  double steady_rate = 1;    ///< largest rate of the wrench's steady part [m g/s], of its moment [m g h/s]
  double edge_force = 0.75;  ///< largest force along each of the four edges, by its normal component [m g]
  bool footholds =
      true;  ///< whether footholds are decisions; else SwingPlanner's, expected at their nominal place
  double least_width = 0.3;  ///< least distance of a foothold from the line below the trunk, over the nominal
  int max_iterations = 3;    ///< largest number of iterations of SLQ per solve
  double tolerance = 1e-4;   ///< expected decrease of the cost, over 1 + cost, at which a solve ends

  static FieldList Fields() {
    return {Field("num_steps", &CentroidalMpcProperties::num_steps).Between(2, 200),
            Field("step_s", &CentroidalMpcProperties::step).Positive(),
            {"weights", &CentroidalMpcProperties::weights},
            {"forecast", &CentroidalMpcProperties::forecast},
            Field("decay_s", &CentroidalMpcProperties::decay).Positive(),
            Field("steady_rate_mg_per_s", &CentroidalMpcProperties::steady_rate).Positive(),
            Field("edge_force_mg", &CentroidalMpcProperties::edge_force).Positive(),
            {"footholds", &CentroidalMpcProperties::footholds},
            Field("least_width", &CentroidalMpcProperties::least_width).Between(0, 1),
            Field("max_iterations", &CentroidalMpcProperties::max_iterations).Between(1, 100),
            Field("tolerance", &CentroidalMpcProperties::tolerance).AtLeast(0)};
  }
};

struct CentroidalMpcParams {
  QuadrupedDescription robot;
  CentroidalMpcProperties mpc{};
  double friction = 0.6;        ///< friction coefficient of the planned forces
  double blend = 0.5;           ///< time within which the reference returns from `body` to the path [s]
  double retarget_phase = 0.7;  ///< swing phase from which the foothold is kept, as in StepProperties
  double gravity = kGravity;    ///< [m/s^2]
  Rate rate = Hz(100);          ///< of `plan`
  Rate reference_rate = Hz(1000);
  void Validate() const;  ///< throws ParameterError
};

/// Statistics of the solves of CentroidalMpc.
struct CentroidalMpcDiagnostics {
  long solves = 0;             ///< since the start of the run
  long failures = 0;           ///< failed solves, after which the shifted last plan is used
  long failures_in_a_row = 0;  ///< failed solves since the last success
  double cost = 0;             ///< cost of the plan
  double solve_time = 0;       ///< wall-clock time of the last solve [s]; does not affect the run

  static FieldList Fields() {
    return {{"solves", &CentroidalMpcDiagnostics::solves},
            {"failures", &CentroidalMpcDiagnostics::failures},
            {"failures_in_a_row", &CentroidalMpcDiagnostics::failures_in_a_row},
            {"cost", &CentroidalMpcDiagnostics::cost},
            {"solve_time", &CentroidalMpcDiagnostics::solve_time, "s"}};
  }
};

/// The first step of CentroidalMpc's plan, and its footholds.
struct CentroidalPlan {
  double start = 0;                        ///< [s]
  BodyReference body;                      ///< at `start`; accelerations are means of the first step
  std::array<Vec<3>, kNumLegs> force_W{};  ///< of the feet on the ground [N]
  std::array<Vec<6>, kNumLegs> push{};     ///< their accelerations of CoM and trunk [m/s^2, rad/s^2]
  Vec<6> free_fall = Vec<6>::Zero();       ///< the accelerations without feet [m/s^2, rad/s^2]
  WrenchEstimate wrench;                   ///< estimated and known wrench, at `start`
  FootholdPlan footholds;
  CentroidalMpcDiagnostics diagnostics;

  CentroidalPlan() {
    force_W.fill(Vec<3>::Zero());
    push.fill(Vec<6>::Zero());
  }
  static FieldList Fields() {
    return {{"start", &CentroidalPlan::start, "s"},
            {"body", &CentroidalPlan::body},
            {"force_W", &CentroidalPlan::force_W, "N", kLegElements},
            {"push", &CentroidalPlan::push, "", kLegElements},
            {"free_fall", &CentroidalPlan::free_fall},
            {"wrench", &CentroidalPlan::wrench},
            {"footholds", &CentroidalPlan::footholds},
            {"diagnostics", &CentroidalPlan::diagnostics}};
  }
};

/// The solver of CentroidalMpc: Slq on a CentroidalWalkProblem.
class CentroidalWalkSolver {
 public:
  using Problem = CentroidalWalkProblem;
  CentroidalWalkSolver(const CentroidalMpcProperties& mpc, double time_unit /* [s] */);
  CentroidalWalkSolver(const CentroidalWalkSolver& other);
  CentroidalWalkSolver& operator=(const CentroidalWalkSolver& other);
  ~CentroidalWalkSolver();

  Problem& problem();
  /// The policy at a node: u + K (x' - x) at the state x'.
  struct Policy {
    Problem::State& x;
    Problem::Input& u;
    Eigen::Matrix<double, Problem::kInputs, Problem::kStates>& K;
  };
  Policy policy(int k);
  /// Improves the policy for a start at x0 with a first step of this length.
  SlqReport Solve(const Problem::State& x0, double first_step);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Model predictive control of a walking robot's centroidal motion: plans the ground forces and footholds
/// over the next `num_steps` steps of the horizon (0.6 s), and outputs the motion of CoM and trunk at its
/// beginning. It takes the place of TrunkPlanner, and of the CoM planner's own motion.
///
/// `body` gives the height, `path` the commanded path with its twist, `wrench` is the estimated one, and
/// `known_wrench` such as that of ropes. `footholds` are those of the swinging feet, for SwingPlanner.
///
/// **Problem.** CentroidalWalkProblem, with the contacts of the schedule at the ends of its steps. Friction
/// cones, as pyramids of four sides inside them, the largest forces along their edges, the reach of a foot
/// from its nominal place, along and across the heading, and its side of the trunk are hard constraints. The
/// reference is the commanded path with the speed and height of `path` and `body`, the trunk parallel to the
/// ground, and equal forces on all edges. While the robot stands, the path is moved to within 0.15 h of the
/// centre of its feet.
///
/// **Disturbance.** The wrench continues over the horizon as `forecast` says; a push that has just begun is
/// expected to end soon, a steady one to last, a sinusoid to go on as it was. It changes the planned motion
/// only: the whole-body controller compensates the wrench in the torques that realise the motion.
///
/// **Footholds.** Each landing within the horizon is a decision: its foothold is displaced from the place
/// below the CoM at touchdown. The nominal displacement is half of the distance that the robot moves in the
/// stance, to which Raibert's rule would add a multiple of the velocity error; here this follows from
/// the dynamics. From retarget_phase on the foothold is kept.
///
/// **Warm start.** Nodes are at multiples of `step`, so that a plan starts from the policy of the last one
/// without interpolation; the first step is shorter. Its feedback keeps the first roll-out stable when a push
/// has thrown the robot off the last plan. If a solve fails, the last plan is used.
///
/// **Reference.** The plan starts at the robot's state. Between solves, position and velocity follow the mean
/// acceleration of the first step; the reference's acceleration is that of the planned forces of the feet
/// which are on the ground.
class CentroidalMpc : public LeafSystem<CentroidalMpcParams> {
 public:
  using LeafSystem::LeafSystem;
  const NominalStance stance{params.robot};

 private:
  const double time_unit_ = std::sqrt(stance.com_height / params.gravity);  // [s]

 public:
  /// The policy of a node, see CentroidalWalkSolver::Policy, and what its inputs mean.
  struct NodePolicy {
    Vec<20> x = Vec<20>::Zero();
    Vec<16> u = Vec<16>::Zero();
    Eigen::Matrix<double, 16, 20, Eigen::DontAlign> K = Eigen::Matrix<double, 16, 20>::Zero();
    std::array<int, kNumLegs> role{};  ///< 1 for a foot on the ground, 2 for a landing, else 0

    static FieldList Fields() {
      return {{"x", &NodePolicy::x},
              {"u", &NodePolicy::u},
              {"K", &NodePolicy::K},
              {"role", &NodePolicy::role, "", kLegElements}};
    }
  };
  struct Memory {
    bool started = false;
    double start = 0;                ///< of the last plan [s]
    Vec<2> origin = Vec<2>::Zero();  ///< of its states [m]
    long grid = 0;                   ///< index of the multiple of `step` before the start
    std::vector<NodePolicy> nodes;
    WrenchEstimate steady;    ///< steady part of the wrench
    WrenchSinusoid sinusoid;  ///< is updated if it is the forecast
    FootholdPlan footholds;
    CentroidalMpcDiagnostics diagnostics;

    static FieldList Fields() {
      return {{"started", &Memory::started},
              {"start", &Memory::start, "s"},
              {"origin", &Memory::origin, "m"},
              {"grid", &Memory::grid},
              {"nodes", &Memory::nodes},
              {"steady", &Memory::steady},
              {"sinusoid", &Memory::sinusoid},
              {"footholds", &Memory::footholds},
              {"diagnostics", &Memory::diagnostics}};
    }
  };

  InputPort<BodyReference> body{this, {"body"}};
  InputPort<PlanarPath> path{this, {"path"}};
  InputPort<ContactSchedule> schedule{this, {"schedule"}};
  InputPort<LeggedState> state{this, {"state"}};
  InputPort<GroundPlane> ground{this, {"ground"}};
  InputPort<WrenchEstimate> wrench{this, {"wrench"}, WrenchEstimate()};
  InputPort<WrenchEstimate> known_wrench{this, {"known_wrench"}, WrenchEstimate()};
  Parameter<CentroidalMpcWeights> weights{
      this, {"weights"}, params.mpc.weights, "weights of the squared errors"};
  Scratch<Memory> memory{this, "memory", FirstMemory()};
  Workspace<CentroidalWalkSolver> solver{this, "solver", CentroidalWalkSolver(params.mpc, time_unit_)};
  OutputPort<CentroidalPlan> plan{
      this,
      {"plan"},
      Sampled{params.rate},
      Uses(time, body, path, schedule, state, ground, wrench, known_wrench, weights, memory, solver),
      &CentroidalMpc::CalcPlan};
  OutputPort<BodyReference> reference{this,
                                      {"reference"},
                                      Sampled{params.reference_rate},
                                      Uses(time, plan, schedule),
                                      &CentroidalMpc::CalcReference};
  OutputPort<FootholdPlan> footholds{
      this, {"footholds"}, Uses(plan), [](const CentroidalPlan& plan_now) { return plan_now.footholds; }};
  OutputPort<CentroidalMpcDiagnostics> diagnostics{
      this, {"diagnostics"}, Uses(plan), [](const CentroidalPlan& plan_now) { return plan_now.diagnostics; }};

 private:
  using Problem = CentroidalWalkProblem;
  Memory FirstMemory() const;
  void SetContacts(const ContactSchedule& schedule, double first_step,
                   const std::array<bool, kNumLegs>& fixed, Problem* problem) const;
  void SetReference(const BodyReference& body, const PlanarPath& path, const ContactSchedule& schedule,
                    const GroundPlane& ground, const Eigen::Vector2d& origin, double first_step,
                    const CentroidalMpcWeights& weights, Problem* problem) const;
  void SetLoads(const WrenchEstimate& wrench, double first_step, Memory& memory, Problem* problem) const;
  void WarmStart(double time, long grid, const Eigen::Vector2d& origin, const Memory& memory,
                 CentroidalWalkSolver& solver) const;
  void Keep(double time, long grid, const Eigen::Vector2d& origin, CentroidalWalkSolver& solver,
            Memory& memory) const;
  void CalcPlan(const double& time, const BodyReference& body, const PlanarPath& path,
                const ContactSchedule& schedule, const LeggedState& state, const GroundPlane& ground,
                const WrenchEstimate& wrench, const WrenchEstimate& known_wrench,
                const CentroidalMpcWeights& weights, Memory& memory, CentroidalWalkSolver& solver,
                CentroidalPlan* plan) const;
  BodyReference CalcReference(const double& time, const CentroidalPlan& plan,
                              const ContactSchedule& schedule) const;

  const QuadrupedModel model_{params.robot, params.gravity};
};

}  // namespace tenon

TENON_DECLARE_SIGNAL(tenon::CentroidalPlan);
TENON_DECLARE_SIGNAL(tenon::CentroidalMpcDiagnostics);
