#pragma once

#include <tenon/controllers/legged/whole_body/whole_body_qp.h>
#include <tenon/plants/model/quadruped_model.h>
#include <tenon/plants/signals/disturbance_signals.h>
#include <tenon/plants/signals/gait_signals.h>
#include <tenon/plants/signals/ground_plane.h>
#include <tenon/plants/signals/motion_signals.h>
#include <tenon/systems/framework/block/parameter.h>
#include <tenon/systems/framework/block/ports.h>
#include <tenon/systems/framework/block/state.h>
#include <tenon/systems/framework/block/system.h>

#include <array>

namespace tenon {

/// How the forces that act on the legs are met.
enum class LegCompensation {
  kExact,   ///< by torques: F_hat is taken off the torques of all legs, within their limits
  kThesis,  ///< by accelerations: eq. (2.41) for the swing feet, nothing in the torques
};
constexpr auto EnumNames(LegCompensation) {
  return std::array{Named{LegCompensation::kExact, "exact"}, Named{LegCompensation::kThesis, "thesis"}};
}

/// The dynamics that the optimisation believes.
enum class BodyDynamics {
  kExact,      ///< of all 18 coordinates, the estimated wrench in them
  kDecoupled,  ///< eq. (2.3): without the wrench, see DecoupledDynamics, and without A' nu in L'
};
constexpr auto EnumNames(BodyDynamics) {
  return std::array{Named{BodyDynamics::kExact, "exact"}, Named{BodyDynamics::kDecoupled, "decoupled"}};
}

/// What is tuned of the whole-body controller; read from a file such as diagrams/profiles/standard.yaml.
struct WholeBodyGains {
  double com_stiffness = 2500;    ///< [N/m]
  double com_damping = 400;       ///< [N s/m]
  double com_limit = 0.08;        ///< an error of the CoM counts up to this length [m]
  double grip_limit = 2;          ///< of what friction holds sideways: the ground is not asked for more
  double trunk_stiffness = 250;   ///< angular acceleration per angle [1/s^2]
  double trunk_damping = 50;      ///< [1/s]
  double turn_limit = 0.2;        ///< an error of the heading counts up to this angle [rad]
  double swing_stiffness = 4900;  ///< acceleration of a swing foot per error [1/s^2]
  double swing_damping = 140;     ///< [1/s]
  double swing_limit = 200;       ///< of both together: a foot that is stuck does not get all torque [m/s^2]
  double stance_damping = 50;     ///< deceleration of a stance foot that moves, per velocity [1/s]
  double stretch_limit = 0.97;    ///< of the leg's length, hip to foot: beyond, a stance foot is drawn in,
  double stretch_stiffness = 2500;  ///< with this acceleration per length [1/s^2]
  BodyDynamics dynamics = BodyDynamics::kExact;
  LegCompensation compensation = LegCompensation::kExact;
  WholeBodyQpParams qp = {};

  static FieldList Fields() {
    return {{"com_stiffness_N_per_m", &WholeBodyGains::com_stiffness},
            {"com_damping_N_s_per_m", &WholeBodyGains::com_damping},
            {"com_limit_m", &WholeBodyGains::com_limit},
            {"grip_limit", &WholeBodyGains::grip_limit},
            {"trunk_stiffness_per_s2", &WholeBodyGains::trunk_stiffness},
            {"trunk_damping_per_s", &WholeBodyGains::trunk_damping},
            {"turn_limit_rad", &WholeBodyGains::turn_limit},
            {"swing_stiffness_per_s2", &WholeBodyGains::swing_stiffness},
            {"swing_damping_per_s", &WholeBodyGains::swing_damping},
            {"swing_limit_m_per_s2", &WholeBodyGains::swing_limit},
            {"stance_damping_per_s", &WholeBodyGains::stance_damping},
            {"stretch_limit", &WholeBodyGains::stretch_limit},
            {"stretch_stiffness_per_s2", &WholeBodyGains::stretch_stiffness},
            {"dynamics", &WholeBodyGains::dynamics},
            {"leg_compensation", &WholeBodyGains::compensation},
            {"qp", &WholeBodyGains::qp}};
  }
  /// Throws ParameterError unless limits and stiffnesses are positive (that of the stretch may be 0, its
  /// limit is at most 1), damping is not negative, and the QP's are valid.
  void Validate() const;
};

struct WholeBodyParams {
  QuadrupedDescription robot;  ///< what the controller believes; gives the torque limits
  WholeBodyGains gains;
  Rate qp_rate = Hz(1000);           ///< of the optimisation
  Rate rate = Hz(1000);              ///< of the torques
  long max_failures_in_a_row = 100;  ///< more end the run
  void Validate() const;             ///< throws ParameterError
};

/// How the solves of the whole-body controller went.
struct WholeBodyDiagnostics {
  long solves = 0;    ///< since the start of the run
  long failures = 0;  ///< of these found nothing, so that the last valid torque went on
  long failures_in_a_row = 0;
  long full_solves = 0;                 ///< in 30 variables instead of 12
  int iterations = 0;                   ///< of the last
  QpStatus status = QpStatus::kSolved;  ///< of the last
  int constraint = -1;                  ///< that its status is about, see QpReport
  double solve_time = 0;                ///< wall-clock time that the last took [s]; nothing depends on it

  static FieldList Fields() {
    return {{"solves", &WholeBodyDiagnostics::solves},
            {"failures", &WholeBodyDiagnostics::failures},
            {"failures_in_a_row", &WholeBodyDiagnostics::failures_in_a_row},
            {"full_solves", &WholeBodyDiagnostics::full_solves},
            {"iterations", &WholeBodyDiagnostics::iterations},
            {"status", &WholeBodyDiagnostics::status},
            {"constraint", &WholeBodyDiagnostics::constraint},
            {"solve_time", &WholeBodyDiagnostics::solve_time, "s"}};
  }
};

/// The last valid solution, and how the last solve went.
struct WholeBodyPlan {
  WholeBodySolution solution;
  WholeBodyDiagnostics diagnostics;

  static FieldList Fields() {
    return {{"solution", &WholeBodyPlan::solution}, {"diagnostics", &WholeBodyPlan::diagnostics}};
  }
};

/// The whole-body controller (Morlando 2023, section 2.4.3): joint torques that make CoM, trunk and swing
/// feet follow their references. At `qp_rate` a quadratic program (see WholeBodyQp) chooses accelerations and
/// forces of the ground for the wrench (2.26) and the accelerations (2.40),
///
///     force   = K_p (x_ref - x) + K_d (x_ref' - x') + m (x_ref'' + g e_z)
///     torque  = I_com (k_p e + k_d (w_ref - w) + alpha_ref),   e from B to its reference: tilt, then turn
///     a_swing = a_ref + [k_d (v_ref - v) + k_p (p_ref - p)],   a_stance = -k_s v + k_l max(0, l - r l_max) u
///
/// and at `rate` the torques of (2.46) are computed from them and the present dynamics, within the limits.
/// If a solve fails it is counted, and the last valid torques stay until one succeeds; a monitor ends the run
/// after `max_failures_in_a_row`.
///
/// x_ref - x is not longer than `com_limit`, and e is the shortest way to upright and then the turn to the
/// heading, of which no more than `turn_limit` counts: a robot that was pushed off its path comes back at a
/// speed that its feet can follow, and one that was turned far knows which way is up. What the force asks of
/// the ground sideways is kept within `grip_limit` times what friction holds: for what is beyond friction,
/// the optimisation presses on the ground with more than is wanted, which helps for a moment and then lifts
/// the robot.
///
/// Feet are spheres that roll on the ground: the stance's v and a are those of the point in contact, where
/// the ground's force acts. The bracket is not longer than `swing_limit`. a_stance stops a foot that is taken
/// to stand but has no contact; with (2.30) alone it would go on at its speed until the leg is straight. And
/// it gives up a foot that is farther from its hip, by l along u, than the part r of the leg's length l_max:
/// a leg that the trunk pulls straight snaps over, and throws the robot.
///
/// Forces that others exert, as observers estimate them, are compensated once: the wrench in the cost and in
/// the trunk's dynamics, what reaches the joints by `compensation`. Give zeros for what is not to be.
///
///     | port        | kind            | type                 |
///     | state       | input           | LeggedState          |
///     | schedule    | input           | ContactSchedule      |
///     | body        | input           | BodyReference        |
///     | feet        | input           | FeetReference        |
///     | wrench      | input           | WrenchEstimate       |
///     | leg_forces  | input           | LegForceEstimate     |
///     | ground      | input           | GroundPlane; level if not connected |
///     | plan        | output, sampled | WholeBodyPlan        |
///     | torque      | output, sampled | Vec<12> [N m]        |
///     | diagnostics | output          | WholeBodyDiagnostics |
///
/// `gains` and `max_failures_in_a_row` are Parameters: a run can change them.
class WholeBodyController final : public LeafSystem<WholeBodyParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPort<LeggedState> state{this, {"state"}};
  InputPort<ContactSchedule> schedule{this, {"schedule"}};
  InputPort<BodyReference> body{this, {"body"}};
  InputPort<FeetReference> feet{this, {"feet"}};
  InputPort<WrenchEstimate> wrench{this, {"wrench"}};
  InputPort<LegForceEstimate> leg_forces{this, {"leg_forces"}};
  InputPort<GroundPlane> ground{this, {"ground"}, GroundPlane()};
  Parameter<WholeBodyGains> gains{
      this, {"gains"}, params.gains, "stiffness, damping and weights of what is asked for"};
  Parameter<long> max_failures_in_a_row{
      this, {"max_failures_in_a_row"}, params.max_failures_in_a_row, "failed solves, more end the run"};

 private:
  QuadrupedModel model_{params.robot};
  Shared<QuadrupedDynamics> dynamics_{this, "dynamics", Uses(state, schedule, ground, gains),
                                      &WholeBodyController::CalcDynamics};
  Scratch<WholeBodyPlan> last_plan_{this, "last_plan", WholeBodyPlan()};
  Workspace<WholeBodyQp> qp_{this, "qp", WholeBodyQp(TorqueLimit(params.robot))};
  Scratch<Vec<12>> last_torque_{this, "last_torque", Vec<12>(Vec<12>::Zero())};

 public:
  OutputPort<WholeBodyPlan> plan{
      this,
      {"plan"},
      Sampled{params.qp_rate},
      Uses(dynamics_, state, schedule, body, feet, wrench, leg_forces, ground, gains, last_plan_, qp_),
      &WholeBodyController::CalcPlan};
  OutputPort<Vec<12>> torque{this,
                             {"torque", "N m", kJointElements},
                             Sampled{params.rate},
                             Uses(dynamics_, plan, leg_forces, gains, last_torque_),
                             &WholeBodyController::CalcTorque};
  OutputPort<WholeBodyDiagnostics> diagnostics{
      this, {"diagnostics"}, Uses(plan), [](const WholeBodyPlan& plan) { return plan.diagnostics; }};

  Monitor solves{this, "solves", Sampled{params.qp_rate}, Uses(plan, max_failures_in_a_row),
                 &WholeBodyController::CheckSolves};

  /// The believed robot, feet that stand by their points in contact; without A' nu where `gains` say so.
  void CalcDynamics(const LeggedState& state, const ContactSchedule& schedule, const GroundPlane& ground,
                    const WholeBodyGains& gains, QuadrupedDynamics* dynamics) const;
  /// What the optimisation is asked for: (2.26), (2.40) and the compensation.
  WholeBodyTask MakeTask(const QuadrupedDynamics& dynamics, const LeggedState& state,
                         const ContactSchedule& schedule, const BodyReference& body,
                         const FeetReference& feet, const WrenchEstimate& wrench,
                         const LegForceEstimate& leg_forces, const GroundPlane& ground,
                         const WholeBodyGains& gains) const;
  /// The torque limits of the joints, in order [N m].
  static Vec<12> TorqueLimit(const QuadrupedDescription& robot);

 private:
  void CalcPlan(const QuadrupedDynamics& dynamics, const LeggedState& state, const ContactSchedule& schedule,
                const BodyReference& body, const FeetReference& feet, const WrenchEstimate& wrench,
                const LegForceEstimate& leg_forces, const GroundPlane& ground, const WholeBodyGains& gains,
                WholeBodyPlan& last, WholeBodyQp& qp, WholeBodyPlan* plan) const;
  Verdict CheckSolves(const WholeBodyPlan& plan, long max_failures_in_a_row) const;
  Vec<12> CalcTorque(const QuadrupedDynamics& dynamics, const WholeBodyPlan& plan,
                     const LegForceEstimate& leg_forces, const WholeBodyGains& gains, Vec<12>& last) const;
};

}  // namespace tenon

TENON_DECLARE_SIGNAL(tenon::WholeBodyPlan);
TENON_DECLARE_SIGNAL(tenon::WholeBodyDiagnostics);
