#pragma once

#include <tenon/controllers/optimization/dual_active_set.h>
#include <tenon/plants/model/quadruped_model.h>

#include <Eigen/Core>

#include <array>

namespace tenon {

/// Weights, friction, and the way to the solution.
struct WholeBodyQpParams {
  double wrench_weight = 100;         ///< Q of the force, per N^2
  double moment_weight = 100;         ///< Q of the torque about the CoM, its horizontal part, per (N m)^2
  double tilt_weight = 0;             ///< what that gains as the trunk tilts, per (N m)^2 and per rad^2
  double free_tilt = 0.3;             ///< up to here it gains nothing [rad]
  double yaw_weight = 100;            ///< Q of the torque's vertical part, at any tilt, per (N m)^2
  double force_weight = 1e-3;         ///< R of the ground's forces, per N^2
  double acceleration_weight = 1e-4;  ///< R of nu'; per (m/s^2)^2 and per (rad/s^2)^2
  double slack_weight = 1e6;          ///< of the swing feet's errors of acceleration, per (m/s^2)^2
  double friction = 1;                ///< mu of the pyramids, that of level ground by default
  bool eliminate = true;              ///< solve the problem in 12 variables wherever that is possible

  static FieldList Fields() {
    return {{"wrench_weight", &WholeBodyQpParams::wrench_weight},
            {"moment_weight", &WholeBodyQpParams::moment_weight},
            {"tilt_weight_per_rad2", &WholeBodyQpParams::tilt_weight},
            {"free_tilt_rad", &WholeBodyQpParams::free_tilt},
            {"yaw_weight", &WholeBodyQpParams::yaw_weight},
            {"force_weight", &WholeBodyQpParams::force_weight},
            {"acceleration_weight", &WholeBodyQpParams::acceleration_weight},
            {"slack_weight", &WholeBodyQpParams::slack_weight},
            {"friction", &WholeBodyQpParams::friction},
            {"eliminate", &WholeBodyQpParams::eliminate}};
  }
  /// Q of the torque's horizontal part at this tilt of the trunk.
  double MomentWeight(double tilt) const {
    const double beyond = tilt > free_tilt ? tilt - free_tilt : 0;
    return moment_weight + tilt_weight * beyond * beyond;
  }
  /// Q, all of it.
  Vec<6> WrenchWeights(double tilt) const {
    const double moment = MomentWeight(tilt);
    Vec<6> weights;
    weights << wrench_weight, wrench_weight, wrench_weight, moment, moment, yaw_weight;
    return weights;
  }
  void Validate() const;  ///< throws ParameterError unless all are positive; the tilt's may be zero
};

/// What the body is to do now.
struct WholeBodyTask {
  std::array<bool, kNumLegs> stance{true, true, true, true};
  Vec<6> wrench = Vec<6>::Zero();                    ///< wanted at the CoM: force, torque about it [N, N m]
  Vec<6> disturbance = Vec<6>::Zero();               ///< the part of it that others exert: w-hat [N, N m]
  Vec<12> joint_disturbance = Vec<12>::Zero();       ///< F-hat, which others exert on the joints [N m]
  std::array<Vec<3>, kNumLegs> foot_acceleration{};  ///< wanted: hard in stance, soft in swing [m/s^2]
  double tilt = 0;                                   ///< of the trunk, from its reference [rad]
  Vec<3> normal_W{0, 0, 1};                          ///< of the ground

  WholeBodyTask() { foot_acceleration.fill(Vec<3>::Zero()); }
};

/// How it does it.
struct WholeBodySolution {
  static constexpr int kMaxActive = 30;

  bool valid = false;                      ///< false before the first solve that succeeds
  Vec<18> acceleration = Vec<18>::Zero();  ///< nu' = (a of B's origin, alpha, qdd)
  FootForces force;                        ///< of the ground [N]
  std::array<bool, kNumLegs> stance{};     ///< the legs that it was made for
  int num_active = 0;                      ///< inequalities that hold with equality,
  std::array<int, kMaxActive> active{};    ///< which begin the next solve

  static FieldList Fields() {
    return {{"valid", &WholeBodySolution::valid},
            {"acceleration", &WholeBodySolution::acceleration},
            {"force", &WholeBodySolution::force},
            {"stance", &WholeBodySolution::stance, "", kLegElements},
            {"num_active", &WholeBodySolution::num_active},
            {"active", &WholeBodySolution::active}};
  }
};

/// The quadratic program of the whole-body controller (Morlando 2023, eqs. (2.22) to (2.45)). With f_i on the
/// stance feet i, slacks gamma_k of the swing feet k, and G f the wrench of all f_i about the CoM:
///
///     min |G f - (w - w_hat)|^2_Q + |f|^2_R + |nu'|^2_R + |gamma|^2_slack      over nu', f, gamma
///     the trunk's rows of   M nu' + h = (w_hat about B's origin, tau + F_hat) + sum J_i^T f_i
///     J_i nu' + J_i' nu = a_i,   J_k nu' + J_k' nu = a_k + gamma_k
///     |f . t_1|, |f . t_2| <= mu f . n,   |tau| <= limit, with tau from the joints' rows
///
/// with the ground's normal n and tangents t_1 and t_2, of which t_1 heads along W's x. J_i is that of the
/// foot's point in contact, see QuadrupedDynamics::Contact, J_k that of the foot's centre: `dynamics.feet`
/// has to hold the one of standing and the other of swinging feet.
///
/// which are the exact dynamics: (2.28) as in the thesis but with w_hat, the slack of (2.43) as an equality,
/// since a symmetric slack is a quadratic cost, and tau less F_hat on all legs in place of (2.41).
///
/// On two feet force and torque contradict each other: a push from the side is met by the friction of the
/// feet, which rolls the trunk, or by letting the CoM go. Q weighs them: the force first, until the trunk
/// tilts, from where on the torque's weight grows with the square of the tilt. The torque about the vertical
/// has a weight of its own: where friction does not suffice for all, a robot that turns is better off than
/// one that tilts.
///
/// It is solved in 30 variables, or in 12: three per leg, f_i or gamma_k. Then each leg's joints follow from
/// trunk and foot by a 3 x 3 solve, qdd = J_leg^-1 (a_foot - J' nu - J_b a_b), and a_b from the trunk's rows
/// by a 6 x 6 solve, so that no equality remains. Where a leg is (nearly) straight J_leg has no inverse, and
/// the problem is solved in its 30 variables.
///
/// Inequality 10 leg + i: i = 0 to 3 the sides of the pyramid (idle in swing), 4 to 9 the lower and upper
/// limits of the leg's torques.
class WholeBodyQp {
 public:
  static constexpr int kRowsPerLeg = 10;

  explicit WholeBodyQp(const Vec<12>& torque_limit);

  /// Starts at the active constraints of `*solution` and replaces it, if all goes well. No allocation.
  QpReport Solve(const QuadrupedDynamics& dynamics, const WholeBodyTask& task,
                 const WholeBodyQpParams& params, WholeBodySolution* solution);

  /// Whether the last Solve() eliminated.
  bool eliminated() const { return eliminated_; }
  /// The last problem, and its solution.
  QuadraticProgram problem() const;
  const DualActiveSet& solver() const { return solver_; }

 private:
  struct Problem {
    Problem(int variables, int equalities);
    Eigen::MatrixXd H;
    Eigen::VectorXd g;
    ConstraintMatrix A_eq;
    Eigen::VectorXd b_eq;
    ConstraintMatrix A_in;
    Eigen::VectorXd b_in;
  };
  bool MakeReduced(const QuadrupedDynamics& dynamics, const WholeBodyTask& task,
                   const WholeBodyQpParams& params);
  void MakeFull(const QuadrupedDynamics& dynamics, const WholeBodyTask& task,
                const WholeBodyQpParams& params);
  static void MakePyramids(const WholeBodyTask& task, double friction, int first, Problem* qp);

  Vec<12> torque_limit_;
  Problem reduced_{12, 0}, full_{30, 18};
  internal::Numbers affine_;  // nu', and more, as functions of y in the reduced problem
  DualActiveSet solver_{30, 18 + kNumLegs* kRowsPerLeg};
  bool eliminated_ = false;
};

/// The direction on ground with this normal along which its pyramid of friction stands: W's x, projected.
Vec<3> FirstTangent(const Vec<3>& normal);

/// The wrench about the CoM as force and torque about B's origin, [N, N m].
Vec<6> AboutBase(const QuadrupedDynamics& dynamics, const Vec<6>& wrench);

/// Joint torques of a motion, eq. (2.46): tau = M nu' + h - J^T f in the joints' rows, less F_hat [N m].
Vec<12> JointTorque(const QuadrupedDynamics& dynamics, const WholeBodySolution& solution,
                    const Vec<12>& joint_disturbance);

/// How forces on the swing feet accelerate them, while the stance feet rest and torques stay: the term J_sw
/// M_c^-1 P J_sw^T f of eq. (2.41), by way of the constrained dynamics [m/s^2]. Zero for stance feet.
std::array<Vec<3>, kNumLegs> SwingFootAcceleration(const QuadrupedDynamics& dynamics,
                                                   const std::array<bool, kNumLegs>& stance,
                                                   const FootForces& force);

}  // namespace tenon
