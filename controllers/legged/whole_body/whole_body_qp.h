#pragma once

#include <tenon/controllers/optimization/dual_active_set.h>
#include <tenon/plants/model/quadruped_model.h>

namespace tenon {

/// How the sides of a friction pyramid approximate the cone |f_t| <= mu f_n.
enum class FrictionPyramid {
  kCircumscribed,  ///< four sides, which touch the cone along W's x and across it; exceeds the cone by up to
                   ///< sqrt(2) in between
  kInscribed,  ///< four sides within the cone, with an edge along the tangential force that the task wants
  kOctagonal,  ///< eight sides within the cone, with an edge in the same direction
};

/// Weights of the cost and the friction coefficient of WholeBodyQp. In files for robots of all sizes they
/// hold for forces in m g, torques in m g l and accelerations in g: the whole cost is multiplied by (m g)^2.
struct WholeBodyQpParams {
  double wrench_weight = 100;         ///< Q of the force [1/N^2]
  double moment_weight = 100;         ///< Q of the horizontal moment about the CoM [1/(N m)^2]
  double tilt_weight = 0;             ///< growth of moment_weight with the tilt [1/(N m rad)^2]
  double free_tilt = 0.3;             ///< tilt of the trunk up to which moment_weight is constant [rad]
  double yaw_weight = 100;            ///< Q of the vertical moment about the CoM [1/(N m)^2]
  double turn_weight = 0;             ///< growth of yaw_weight with the turn [1/(N m rad)^2]
  double free_turn = 0.2;             ///< turn of the trunk up to which yaw_weight is constant [rad]
  double force_weight = 1e-3;         ///< R of the ground forces [1/N^2]
  double acceleration_weight = 1e-4;  ///< R of nu' [(m/s^2)^-2], [(rad/s^2)^-2]
  double slack_weight = 1e6;          ///< weight of the swing feet's acceleration errors [(m/s^2)^-2]
  double friction = 1;                ///< coefficient mu of the friction pyramids
  FrictionPyramid friction_pyramid = FrictionPyramid::kCircumscribed;

  static FieldList Fields() {
    using P = WholeBodyQpParams;
    const auto moment = [](double w, const Scale& s) { return w / (s.length * s.length); };
    const auto acceleration = [](double w, const Scale& s) { return w * (s.mass * s.mass); };
    return {Field("wrench_weight", &P::wrench_weight).Positive().Scaled(),
            Field("moment_weight", &P::moment_weight).Positive().Scaled("moment_weight", moment),
            Field("tilt_weight_per_rad2", &P::tilt_weight).AtLeast(0).Scaled("tilt_weight_per_rad2", moment),
            Field("free_tilt_rad", &P::free_tilt).AtLeast(0),
            Field("yaw_weight", &P::yaw_weight).Positive().Scaled("yaw_weight", moment),
            Field("turn_weight_per_rad2", &P::turn_weight).AtLeast(0).Scaled("turn_weight_per_rad2", moment),
            Field("free_turn_rad", &P::free_turn).AtLeast(0),
            Field("force_weight", &P::force_weight).Positive().Scaled(),
            Field("acceleration_weight", &P::acceleration_weight)
                .Positive()
                .Scaled("acceleration_weight", acceleration),
            Field("slack_weight", &P::slack_weight).Positive().Scaled("slack_weight", acceleration),
            Field("friction", &WholeBodyQpParams::friction).Positive(),
            Field("friction_pyramid", &WholeBodyQpParams::friction_pyramid)};
  }
  /// Weight of the horizontal moment at this tilt of the trunk [rad].
  double MomentWeight(double tilt) const { return Grown(moment_weight, tilt_weight, tilt - free_tilt); }
  /// Diagonal of Q, force before moment, at this tilt of the trunk and turn [rad]. The weight of the vertical
  /// moment grows up to that of the horizontal one.
  Vec<6> WrenchWeights(double tilt, double turn) const {
    const double moment = MomentWeight(tilt), grown = Grown(yaw_weight, turn_weight, turn - free_turn);
    Vec<6> weights;
    weights << wrench_weight, wrench_weight, wrench_weight, moment, moment,
        std::max(yaw_weight, std::min(grown, moment));
    return weights;
  }

 private:
  static double Grown(double weight, double growth, double beyond) {
    return beyond > 0 ? weight + growth * beyond * beyond : weight;
  }
};

/// Inputs of one WholeBodyQp.
struct WholeBodyTask {
  std::array<bool, kNumLegs> stance{true, true, true, true};
  Vec<6> wrench = Vec<6>::Zero();                    ///< w, desired at the CoM: force, moment [N, N m]
  Vec<6> disturbance = Vec<6>::Zero();               ///< w_hat, estimated external wrench at the CoM [N, N m]
  Vec<12> joint_disturbance = Vec<12>::Zero();       ///< F_hat, estimated external joint torques [N m]
  std::array<Vec<3>, kNumLegs> foot_acceleration{};  ///< a_i, a constraint in stance, soft in swing [m/s^2]
  double tilt = 0;                                   ///< angle between the trunk's z and its reference [rad]
  double turn = 0;                                   ///< about that reference, see WholeBodyController [rad]
  Vec<3> normal_W{0, 0, 1};                          ///< unit normal of the ground
  /// upper bounds of the stance feet's normal forces, at least 0 [N]
  Vec<4> largest_load = Vec<4>::Constant(std::numeric_limits<double>::infinity());

  WholeBodyTask() { foot_acceleration.fill(Vec<3>::Zero()); }
};

/// Solution of a WholeBodyQp.
struct WholeBodySolution {
  static constexpr int kMaxActive = 30;

  bool valid = false;                      ///< false until a solve succeeds
  Vec<18> acceleration = Vec<18>::Zero();  ///< nu' = (linear of B's origin, angular of B, joints)
  FootForces force;                        ///< ground forces, zero on swing feet [N]
  std::array<bool, kNumLegs> stance{};     ///< stance legs of the task
  int num_active = 0;                      ///< number of active inequalities
  std::array<int, kMaxActive> active{};    ///< active inequalities, the warm start of the next solve

  static FieldList Fields() {
    return {{"valid", &WholeBodySolution::valid},
            {"acceleration", &WholeBodySolution::acceleration},
            {"force", &WholeBodySolution::force},
            {"stance", &WholeBodySolution::stance, "", kLegElements},
            {"num_active", &WholeBodySolution::num_active},
            {"active", &WholeBodySolution::active}};
  }
};

/// The quadratic program of the whole-body controller (Morlando 2023, eqs. (2.22) to (2.45)). With the ground
/// forces f_i on the stance feet i, slacks gamma_k of the swing feet k, and the wrench G f of all f_i about
/// the CoM:
///
///     min |G f - (w - w_hat)|^2_Q + |f|^2_R + |nu'|^2_R + |gamma|^2_slack      over nu', f, gamma
///     the trunk's rows of   M nu' + h = (w_hat about B's origin, tau + F_hat) + sum J_i^T f_i
///     J_i nu' + J_i' nu = a_i,   J_k nu' + J_k' nu = a_k + gamma_k
///     |f . t_1|, |f . t_2| <= mu f . n <= mu largest_load,   |tau| <= limit, with tau from the joints' rows
///
/// with the ground's normal n and its tangents t_1, along W's x, and t_2. The inscribed pyramid has mu
/// cos(45 deg) instead of mu, and t_1 at 45 degrees to the tangential part of w - w_hat, in whose direction a
/// foot can then have the friction mu. The octagonal one has 22.5 degrees instead, and the same inequalities
/// also for two tangents that are turned by 45 degrees. J_i is the Jacobian of the foot's contact point (see
/// QuadrupedDynamics::Contact), J_k that of the foot's centre: `dynamics.feet` must hold contact points for
/// stance feet and centres for swing feet.
///
/// The constraints are the exact rigid-body dynamics. They differ from the thesis in three ways: (2.28)
/// includes w_hat, the slack of (2.43) is an equality, since a symmetric slack is equivalent to a quadratic
/// cost, and F_hat is subtracted from the torques of all legs instead of (2.41).
///
/// On two feet, force and moment cannot be realised independently: friction that resists a push from the side
/// rolls the trunk. Q weighs the force first; once the trunk tilts by more than free_tilt, the weight of the
/// moment grows with the square of the excess. The vertical moment has a separate, small weight, so that the
/// robot turns rather than tilts when friction saturates; it grows likewise once the turn exceeds free_turn,
/// up to that of the horizontal moment.
///
/// **Elimination.** The program is solved in 12 variables, f_i or gamma_k of each leg. The joints of a leg
/// follow from trunk and foot, qdd = J_leg^-1 (a_foot - J' nu - J_b a_b), and the trunk's acceleration a_b
/// from its six rows of the dynamics, so that no equality constraint remains. The singular values of a nearly
/// straight leg's J_leg are raised to a lower bound of 2e-4 |J_leg|, which keeps the inverse finite.
///
/// Inequalities 10 leg to 10 leg + 3 are the sides of the friction pyramid (0 >= -1 in swing), 10 leg + 4 to
/// 10 leg + 9 the lower and upper limits of the leg's torques. If a load is bounded or the pyramid is
/// octagonal, 40 + leg are the bounds of the loads (0 >= -1 if infinite), and 44 + 4 leg to 47 + 4 leg the
/// other four sides of the octagonal pyramid.
class WholeBodyQp {
 public:
  static constexpr int kRowsPerLeg = 10;
  static constexpr int kMaxRows = kNumLegs * (kRowsPerLeg + 1 + 4);

  explicit WholeBodyQp(const Vec<12>& torque_limit);

  /// Solves with the active set of `*solution` as warm start, and replaces `*solution` if the solve succeeds.
  /// Does not allocate.
  QpReport Solve(const QuadrupedDynamics& dynamics, const WholeBodyTask& task,
                 const WholeBodyQpParams& params, WholeBodySolution* solution);

  /// The program of the last Solve(), in f and gamma, three entries a leg.
  QuadraticProgram problem() const {
    return {H_, g_, A_eq_, b_eq_, A_in_.topRows(num_rows_), b_in_.head(num_rows_)};
  }
  const DualActiveSet& solver() const { return solver_; }

 private:
  void MakeProblem(const QuadrupedDynamics& dynamics, const WholeBodyTask& task,
                   const WholeBodyQpParams& params);
  void MakePyramids(const WholeBodyTask& task, const WholeBodyQpParams& params);
  void BoundLoads(const WholeBodyTask& task, const WholeBodyQpParams& params);

  Vec<12> torque_limit_;
  Eigen::MatrixXd H_;
  Eigen::VectorXd g_;
  ConstraintMatrix A_eq_, A_in_;
  Eigen::VectorXd b_eq_, b_in_;
  int num_rows_ = kNumLegs * kRowsPerLeg;  // inequalities in use
  internal::Numbers affine_;               // nu' and the wrench error as affine functions of f and gamma
  DualActiveSet solver_{12, kMaxRows};
};

/// Unit vector on the ground along the projection of W's x, the first axis of the friction pyramid.
Vec<3> FirstTangent(const Vec<3>& normal);

/// A wrench at the CoM, expressed at B's origin: force and moment [N, N m].
Vec<6> AboutBase(const QuadrupedDynamics& dynamics, const Vec<6>& wrench);

/// Joint torques of a solution, eq. (2.46): tau = M nu' + h - J^T f (joints' rows) - F_hat [N m].
Vec<12> JointTorque(const QuadrupedDynamics& dynamics, const WholeBodySolution& solution,
                    const Vec<12>& joint_disturbance);

/// Accelerations of the swing feet due to forces on them, with the stance feet at rest and constant torques:
/// the term J_sw M_c^-1 P J_sw^T f of eq. (2.41), from the constrained dynamics [m/s^2]. Zero for stance
/// feet.
std::array<Vec<3>, kNumLegs> SwingFootAcceleration(const QuadrupedDynamics& dynamics,
                                                   const std::array<bool, kNumLegs>& stance,
                                                   const FootForces& force);

}  // namespace tenon
