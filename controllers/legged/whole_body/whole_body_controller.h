#pragma once

#include <tenon/controllers/legged/comparison/sliding_mode.h>
#include <tenon/controllers/legged/whole_body/whole_body_qp.h>
#include <tenon/plants/signals/disturbance_signals.h>
#include <tenon/plants/signals/gait_signals.h>
#include <tenon/plants/signals/motion_signals.h>
#include <tenon/systems/block.h>

namespace tenon {

/// Compensation of external forces on the legs.
enum class LegCompensation {
  kExact,   ///< torques: F_hat is subtracted from the torques of all legs, within their limits
  kThesis,  ///< accelerations: eq. (2.41) for the swing feet, torques unchanged
};

/// Equations of motion in the optimisation.
enum class BodyDynamics {
  kExact,        ///< all 18 coordinates, with the estimated wrench
  kDecoupled,    ///< eq. (2.3), see DecoupledDynamics: without the wrench, and without A' nu in L'
  kQuasiStatic,  ///< one rigid body and legs that do not move it, without C nu, with the wrench
};

/// Gains of the whole-body controller, read from a file such as diagrams/profiles/standard.yaml.
struct WholeBodyGains {
  double com_stiffness = 2500;      ///< K_p [N/m]
  double com_damping = 400;         ///< K_d [N s/m]
  double com_limit = 0.08;          ///< saturation of the CoM position error [m]
  double grip_limit = 2;            ///< saturation of the tangential ground force, in multiples of friction
  double trunk_stiffness = 250;     ///< k_p: angular acceleration per angle [1/s^2]
  double trunk_damping = 50;        ///< k_d [1/s]
  double turn_limit = 0.2;          ///< saturation of the heading error [rad]
  double swing_stiffness = 4900;    ///< acceleration of a swing foot per position error [1/s^2]
  double swing_damping = 140;       ///< acceleration of a swing foot per velocity error [1/s]
  double swing_limit = 200;         ///< saturation of a swing foot's feedback acceleration [m/s^2]
  double stance_damping = 50;       ///< k_s: deceleration of a moving stance foot per velocity [1/s]
  double stretch_limit = 0.97;      ///< r: extension of a stance leg, over its longest, not corrected
  double stretch_stiffness = 2500;  ///< k_l: acceleration towards the hip per length beyond that [1/s^2]
  double load_ramp = 0;             ///< time in which a foot takes and gives up the robot's weight [s]
  /// predicted tilt about the line of two stance feet beyond which the CoM yields [rad]
  double tip_limit = std::numeric_limits<double>::infinity();
  double tip_margin = 0.05;  ///< time from a touchdown until the foot has stopped the tilt [s]
  BodyDynamics dynamics = BodyDynamics::kExact;
  LegCompensation compensation = LegCompensation::kExact;
  WholeBodyQpParams qp = {};
  std::optional<SlidingGains> sliding = {};  ///< replaces stiffnesses and dampings; empty: it does not

  static FieldList Fields() {
    using G = WholeBodyGains;
    return {
        Field("com_stiffness_N_per_m", &G::com_stiffness)
            .Positive()
            .Because("with 0 errors are not corrected")
            .Scaled("com_stiffness_mg_per_l",
                    [](double k, const Scale& s) { return k * (s.mass * s.gravity / s.length); }),
        Field("com_damping_N_s_per_m", &G::com_damping)
            .AtLeast(0)
            .Because("negative damping is unstable")
            .Scaled("com_damping_mg_t_per_l",
                    [](double k, const Scale& s) { return k * (s.mass * s.gravity * s.Time() / s.length); }),
        Field("com_limit_m", &G::com_limit)
            .Positive()
            .OrInfinite()
            .Scaled("com_limit_l", [](double limit, const Scale& s) { return limit * s.length; }),
        Field("grip_limit", &G::grip_limit).Positive().OrInfinite(),
        Field("trunk_stiffness_per_s2", &G::trunk_stiffness)
            .Positive()
            .Because("with 0 errors are not corrected"),
        Field("trunk_damping_per_s", &G::trunk_damping).AtLeast(0).Because("negative damping is unstable"),
        Field("turn_limit_rad", &G::turn_limit).Positive().OrInfinite(),
        Field("swing_stiffness_per_s2", &G::swing_stiffness)
            .Positive()
            .Because("with 0 errors are not corrected"),
        Field("swing_damping_per_s", &G::swing_damping).AtLeast(0).Because("negative damping is unstable"),
        Field("swing_limit_m_per_s2", &G::swing_limit)
            .Positive()
            .OrInfinite()
            .Scaled("swing_limit_g", [](double limit, const Scale& s) { return limit * s.gravity; }),
        Field("stance_damping_per_s", &G::stance_damping).AtLeast(0).Because("negative damping is unstable"),
        Field("stretch_limit", &G::stretch_limit).Above(0).AtMost(1).Because("1 is a straight leg"),
        Field("stretch_stiffness_per_s2", &G::stretch_stiffness).AtLeast(0).Because("0 turns it off"),
        Field("load_ramp_s", &G::load_ramp).AtLeast(0).Because("0 turns it off"),
        Field("tip_limit_rad", &G::tip_limit).Positive().OrInfinite(),
        Field("tip_margin_s", &G::tip_margin)
            .Positive()
            .Scaled("tip_margin_t", [](double time, const Scale& s) { return time * s.Time(); }),
        {"dynamics", &G::dynamics},
        {"leg_compensation", &G::compensation},
        {"qp", &G::qp},
        {"sliding", &G::sliding}};
  }
};

struct WholeBodyParams {
  QuadrupedDescription robot;  ///< the controller's model, with the torque limits
  WholeBodyGains gains;
  Rate qp_rate = Hz(1000);           ///< rate of the optimisation
  Rate rate = Hz(1000);              ///< rate of the torques
  long max_failures_in_a_row = 100;  ///< number of consecutive failed solves above which the run ends
};

/// Statistics of the whole-body controller's solves.
struct WholeBodyDiagnostics {
  long solves = 0;                      ///< since the start of the run
  long failures = 0;                    ///< failed solves, after which the last valid torques stay
  long failures_in_a_row = 0;           ///< failed solves since the last success
  int iterations = 0;                   ///< iterations of the last solve
  QpStatus status = QpStatus::kSolved;  ///< status of the last solve
  int constraint = -1;                  ///< constraint that the status refers to, see QpReport
  double solve_time = 0;                ///< wall-clock time of the last solve [s]; no block depends on it

  static FieldList Fields() {
    return {{"solves", &WholeBodyDiagnostics::solves},
            {"failures", &WholeBodyDiagnostics::failures},
            {"failures_in_a_row", &WholeBodyDiagnostics::failures_in_a_row},
            {"iterations", &WholeBodyDiagnostics::iterations},
            {"status", &WholeBodyDiagnostics::status},
            {"constraint", &WholeBodyDiagnostics::constraint},
            {"solve_time", &WholeBodyDiagnostics::solve_time, "s"}};
  }
};

/// The last valid solution and the statistics of the solves.
struct WholeBodyPlan {
  WholeBodySolution solution;
  WholeBodyDiagnostics diagnostics;

  static FieldList Fields() {
    return {{"solution", &WholeBodyPlan::solution}, {"diagnostics", &WholeBodyPlan::diagnostics}};
  }
};

/// The whole-body controller (Morlando 2023, section 2.4.3): joint torques that make CoM, trunk and swing
/// feet follow their references. At `qp_rate` a quadratic program (see WholeBodyQp) computes accelerations
/// and ground forces for the wrench (2.26) and the foot accelerations (2.40),
///
///     force   = K_p (x_ref - x) + K_d (x_ref' - x') + m (x_ref'' + g e_z)
///     moment  = I_com (k_p e + k_d (w_ref - w) + alpha_ref),   e from B to its reference: tilt, then turn
///     a_swing = a_ref + [k_d (v_ref - v) + k_p (p_ref - p)],   a_stance = -k_s v + k_l max(0, l - r l_max) u
///
/// and at `rate` the torques (2.46) are computed from its solution and the present dynamics, within the
/// limits. After a failed solve the last valid torques stay until a solve succeeds; a monitor ends the run
/// after more than `max_failures_in_a_row` failures.
///
/// **Saturation.** |x_ref - x| is limited to `com_limit` and the turn in e to `turn_limit`, so that a robot
/// that was pushed off its path returns at a speed that its feet can follow, and rights itself before it
/// turns to its heading. The tangential components of the desired ground force are limited to `grip_limit`
/// times friction: beyond friction, the optimisation would increase the normal force above its desired value,
/// which lifts the robot. The bracket of a_swing is limited to `swing_limit`, so that a stuck foot does not
/// take all the torque.
///
/// **Sliding mode.** With `sliding`, for comparison, the accelerations of SlidingMode replace the linear
/// feedback of the CoM, times m, of the trunk and of the swing feet; the saturations of the errors stay.
///
/// **Quasi-static control.** BodyDynamics::kQuasiStatic, for comparison, is the trunk controller of Focchi et
/// al. (High-slope terrain locomotion for torque-controlled quadruped robots, Autonomous Robots 41, 2017):
/// the ground forces f_i hold the wrench as if the robot were one rigid body, and the torques of a leg,
///
///     tau = M_leg qdd + gravity - J_leg^T f,
///
/// contain the inertia M_leg of that leg alone, on a trunk at rest.
///
/// **Stance feet.** Feet are spheres that roll on the ground: v and a of a stance foot are those of its
/// contact point. a_stance stops a foot that is scheduled to stand but has no contact; with (2.30) alone it
/// would keep its velocity until the leg is straight. It also pulls a foot towards its hip (unit vector u) if
/// their distance l exceeds the fraction r of the longest that the knee's range allows
/// (QuadrupedDescription::LongestExtension), since a leg that the trunk pulls straight snaps through its
/// singularity or hits an end stop.
///
/// **Tipping.** Two feet exert no moment about the line between them, with direction n. A force F of the
/// ground that holds the CoM x against an external wrench (f, t) therefore turns the robot, whose inertia is
/// I_com, by
///
///     alpha = n . ((p - x) x F + t) / (n . I_com n)        with the position p of one of the feet,
///
/// and with the tilt e and the rate w relative to the reference, the tilt about the line is
///
///     n . (e + w T) + (alpha - n . alpha_ref) T^2 / 2,     T = time to touchdown + tip_margin,
///
/// when the feet in the air have landed and stop it. (I_com is that of the robot with locked joints. A trunk
/// whose swing legs stay behind turns by more.) If it exceeds `tip_limit`, the tangential component of F
/// across the line is reduced until it does not: the CoM yields to the push. The angular momentum about the
/// line is the same, but as a motion of the CoM the next stance of all feet can return it, while as a
/// rotation of the trunk it moves the feet out of reach.
///
/// **Turning.** The weight of the vertical moment grows with the turn e_z + k_d / k_p (w_ref - w)_z, which is
/// the desired angular acceleration over k_p before its saturation. When friction saturates under a push that
/// also turns the robot, a small weight lets the robot turn at once, and for as long as the push lasts.
///
/// **Load ramps.** With a `load_ramp` T above 0, the normal force of a foot is at most s m g while s < 1: s
/// grows from 0 to 1 within T after touchdown and falls to 0 within T before the planned lift-off. T is
/// limited to half of the time in which all feet stand. A foot whose lift-off waits for another one is not
/// unloaded.
///
/// **Disturbances.** Estimated external forces are compensated once: the wrench in the cost and in the
/// trunk's dynamics, joint torques by `compensation`, except a torque that pushes a joint back into its
/// range: an end stop exerts it. Connect zeros to compensate nothing. `known_wrench` is added to the wrench:
/// forces that are not estimated, such as those of ropes (see RopeTensions).
class WholeBodyController final : public LeafSystem<WholeBodyParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPort<LeggedState> state{this, {"state"}};
  InputPort<ContactSchedule> schedule{this, {"schedule"}};
  InputPort<BodyReference> body{this, {"body"}};
  InputPort<FeetReference> feet{this, {"feet"}};
  InputPort<WrenchEstimate> wrench{this, {"wrench"}};
  InputPort<WrenchEstimate> known_wrench{this, {"known_wrench"}, WrenchEstimate()};
  InputPort<LegForceEstimate> leg_forces{this, {"leg_forces"}};
  InputPort<GroundPlane> ground{this, {"ground"}, GroundPlane()};
  Parameter<WholeBodyGains> gains{
      this, {"gains"}, params.gains, "stiffnesses, dampings, limits and weights of the controller"};
  Parameter<long> max_failures_in_a_row{this,
                                        {"max_failures_in_a_row"},
                                        params.max_failures_in_a_row,
                                        "consecutive failed solves above which the run ends",
                                        Range().AtLeast(0).Because("0 ends the run at the first failure")};

 private:
  static std::array<double, kNumLegs> Extensions(const QuadrupedDescription& robot);
  const std::array<double, kNumLegs> extension_ = Extensions(params.robot);  // longest of each leg [m]
  QuadrupedModel model_{params.robot};
  Shared<QuadrupedDynamics> of_model_{this, "dynamics_of_model", Uses(state), model_};
  Shared<QuadrupedDynamics> dynamics_{this, "dynamics", Uses(of_model_, schedule, ground, gains),
                                      &WholeBodyController::CalcDynamics};
  Shared<LegForceEstimate> free_of_stops_{this, "leg_forces_free_of_stops", Uses(leg_forces, state),
                                          &WholeBodyController::CalcFreeOfStops};
  Scratch<WholeBodyPlan> last_plan_{this, "last_plan", WholeBodyPlan()};
  Scratch<Vec<4>> loading_{this, "loading", Vec<4>::Ones()};  // progress of the load ramps, 0 to 1
  Workspace<WholeBodyQp> qp_{this, "qp", WholeBodyQp(TorqueLimit(params.robot))};
  Scratch<Vec<12>> last_torque_{this, "last_torque", Vec<12>(Vec<12>::Zero())};

 public:
  OutputPort<WholeBodyPlan> plan{this,
                                 {"plan"},
                                 Sampled{params.qp_rate},
                                 Uses(dynamics_, state, schedule, body, feet, wrench, known_wrench,
                                      free_of_stops_, ground, gains, last_plan_, loading_, qp_),
                                 &WholeBodyController::CalcPlan};
  OutputPort<Vec<12>> torque{this,
                             {"torque", "N m", kJointElements},
                             Sampled{params.rate},
                             Uses(dynamics_, plan, free_of_stops_, gains, last_torque_),
                             &WholeBodyController::CalcTorque};
  OutputPort<WholeBodyDiagnostics> diagnostics{
      this, {"diagnostics"}, Uses(plan), [](const WholeBodyPlan& plan_now) { return plan_now.diagnostics; }};

  Monitor solves{this, "solves", Sampled{params.qp_rate}, Uses(plan, max_failures_in_a_row),
                 &WholeBodyController::CheckSolves};

  /// The dynamics `of_model` with contact points in place of the stance feet's centres, and without what
  /// `gains.dynamics` neglects.
  void CalcDynamics(const QuadrupedDynamics& of_model, const ContactSchedule& schedule,
                    const GroundPlane& ground, const WholeBodyGains& gains,
                    QuadrupedDynamics* dynamics) const;
  /// Task of the optimisation: the wrench (2.26), the foot accelerations (2.40) and the compensation.
  WholeBodyTask MakeTask(const QuadrupedDynamics& dynamics, const LeggedState& state,
                         const ContactSchedule& schedule, const BodyReference& body,
                         const FeetReference& feet, const WrenchEstimate& wrench,
                         const LegForceEstimate& leg_forces, const GroundPlane& ground,
                         const WholeBodyGains& gains) const;
  /// Torque limits of the joints [N m].
  static Vec<12> TorqueLimit(const QuadrupedDescription& robot);

 private:
  void CalcFreeOfStops(const LegForceEstimate& leg_forces, const LeggedState& state,
                       LegForceEstimate* free_of_stops) const;
  void CalcPlan(const QuadrupedDynamics& dynamics, const LeggedState& state, const ContactSchedule& schedule,
                const BodyReference& body, const FeetReference& feet, const WrenchEstimate& wrench,
                const WrenchEstimate& known_wrench, const LegForceEstimate& leg_forces,
                const GroundPlane& ground, const WholeBodyGains& gains, WholeBodyPlan& last, Vec<4>& loading,
                WholeBodyQp& qp, WholeBodyPlan* plan) const;
  void LimitLoads(const ContactSchedule& schedule, double load_ramp, Vec<4>* loading,
                  WholeBodyTask* task) const;
  Verdict CheckSolves(const WholeBodyPlan& plan, long max_failures_in_a_row) const;
  Vec<12> CalcTorque(const QuadrupedDynamics& dynamics, const WholeBodyPlan& plan,
                     const LegForceEstimate& leg_forces, const WholeBodyGains& gains, Vec<12>& last) const;
};

}  // namespace tenon

TENON_DECLARE_SIGNAL(tenon::WholeBodyPlan);
TENON_DECLARE_SIGNAL(tenon::WholeBodyDiagnostics);
