#pragma once

#include <tenon/plants/legged/body_contact.h>
#include <tenon/plants/legged/extended_quadruped.h>
#include <tenon/plants/legged/quadruped_geometry.h>
#include <tenon/systems/block.h>

namespace tenon {

struct QuadrupedPlantParams {
  QuadrupedDescription robot;
  RigidInertia payload;  ///< fixed to the trunk, in B; none by default
  TerrainParams terrain;
  LeggedState initial;
  double gravity = kGravity;  ///< [m/s^2]
  bool limit_speed = true;    ///< the drives' torque falls with speed
  ExtendQuadruped extend;     ///< adds to the robot in Simbody, see QuadrupedPlant; nothing by default

  void Validate() const;  ///< throws ParameterError
};

/// Torque of a drive for a command [N m] at the joint speed qd [rad/s], see QuadrupedPlant. NaN is
/// propagated.
double DriveTorque(double command, double qd, const JointDescription& joint, const DriveProperties& drive,
                   bool limit_speed = true);

/// Bristle states of the feet, see foot_contact.h.
struct FootBristles {
  Vec<8> z = Vec<8>::Zero();  ///< two for each leg [m]
  static FieldList Fields() { return {{"z", &FootBristles::z, "m"}}; }
};

/// Contacts of the feet, and forces on other bodies that touch the ground.
struct FootContacts {
  std::array<FootContact, kNumLegs> feet;
  BodyContact::Forces bodies;
};

/// Mechanical energy of the robot [J]; the potential is that of gravity, 0 at z = 0.
struct LeggedEnergy {
  double kinetic = 0;
  double potential = 0;
  double total() const { return kinetic + potential; }
  static FieldList Fields() {
    return {{"kinetic", &LeggedEnergy::kinetic, "J"}, {"potential", &LeggedEnergy::potential, "J"}};
  }
};

/// A quadruped on terrain: rigid bodies in Simbody (quadruped_body.h), compliant contacts with friction
/// (foot_contact.h).
///
/// Only `torque` must be connected. `external` has up to eight forces and torques on the robot:
/// `external_torque` are their torques on the joints, and `external_wrench`, with the payload's weight, is
/// their wrench about the CoM without payload. `added_wrench` is that of the additions about the same point,
/// in W. NaN as the reference of a drive of an added joint stands for that of the drive's own parameters,
/// see AttachedBody. `acceleration` is that of B's origin and of the joints, `joint_torque` the torque of
/// the drives within their limits, and `foot_slips` the tangential velocity of each foot's contact point.
///
/// **Additions.** The function `extend` adds bodies, joints, forces, constraints and contacts to the robot in
/// Simbody; robot_multibody.h is the guide and quadruped_multibody.h names the bodies,
/// docs/examples/compose/swinging_load.cc a complete program, and attached_bodies.h adds bodies from
/// parameters. Simbody then computes all accelerations, and the coordinates, speeds and auxiliary variables
/// of the additions are the states added_q, added_u and added_z. `energy` includes the additions.
/// `external_wrench` does not, and controllers know the robot alone unless they measure `added_wrench`. That
/// comes from the balance of momentum of the robot's own bodies, including the payload,
///
///     f = p' - m g - (forces of ground and `external`),   t likewise about the CoM,
///
/// so it contains the reactions of added joints, force elements and constraints on all bodies of the robot;
/// the sum of both wrenches is the disturbance that an observer sees. Without `extend`, `added_wrench` is 0,
/// the equations of quadruped_body.h hold, which are faster, and these states are empty.
///
/// **Drives.** The torque is the command limited to the torque limit. With `limit_speed` it is also limited
/// to the torque-speed line of the motor: full torque up to a fraction r of the speed limit w, then falling
/// linearly to 0 at the limit, and braking above,
///
///     tau <= limit min(1, (w - qd) / ((1 - r) w)), not below -limit, and the mirror image for qd < 0.
///
/// Friction is viscous plus Coulomb friction, which is smoothed below 0.1 rad/s. End stops apply the torque
/// k e max(0, 1 + c e') for an angle e beyond the range, a continuous and dissipative model. The rotor
/// inertia acts on the joint alone, without gyroscopic torque on the trunk.
///
/// The length of the quaternion does not affect the motion; the term 5 (1 - |q|^2) q of its derivative brings
/// it to 1. Feet touch the ground as described in foot_contact.h, all other bodies as in body_contact.h, so
/// a robot without torque comes to lie. Bodies of the robot do not touch each other.
///
/// **Integration.** Use an explicit method with error control, since impacts need short steps. Order 2 with
/// rtol = 1e-2 and absolute tolerances of 1e-4 m and rad, 1e-2 m/s and rad/s, and 1e-6 m for the bristles
/// deviates by less than 0.05 mm from the exact motion in a landing from 10 cm and in a trot under joint PD
/// at 1 kHz (0.4 N rms in the foot forces), with 3 and 6 evaluations per ms; standing takes 2. Ten times
/// tighter tolerances are not more accurate, since the error is dominated by feet that touch down late within
/// a step. Order 3 with one hundredth of these tolerances deviates by less than 0.01 mm in the trot, with 14
/// evaluations per ms. A loaded shank decays at up to 4000 /s, so stability limits the steps of Method::kErk
/// to half a millisecond in that trot; kStabilized of order 2 with 1e-3 m, 1e-1 m/s and 1e-5 m takes steps of
/// one millisecond with 3 evaluations and deviates by less than 0.17 mm. A sliding foot is stiff, with a rate
/// of its speed over z_max, and its friction depends on the error of the bristle: at 1 m/s it is 0.3 % too
/// small. z_max has a lower bound, so ground may be arbitrarily slippery.
///
/// Throws RunError for an external force on an invalid body, and if the number of added forces or references
/// is wrong.
class QuadrupedPlant final : public LeafSystem<QuadrupedPlantParams> {
 public:
  using LeafSystem::LeafSystem;
  const Terrain terrain{params.terrain};

 private:
  const QuadrupedDescription loaded_{WithPayload(params.robot, params.payload)};
  const BodyContact body_contact_{loaded_, params.terrain};
  const ExtendedQuadruped additions_{loaded_, params.gravity, params.extend, params.initial};

 public:
  /// Names, units and initial values of the states and inputs of the additions.
  const ExtendedQuadruped::Additions& additions = additions_.additions();
  /// The robot without the part of the trunk that additions replace, for shapes.
  const QuadrupedDescription bare_robot = Without(params.robot, additions.replaced);

  InputPort<Vec<12>> torque{this, {"torque", "N m"}};
  InputPort<ExternalForces> external{this, {"external"}, ExternalForces{}};
  InputPort<JointLocks> locks{this, {"locks"}, JointLocks{}};
  InputPort<Eigen::VectorXd> added_forces{this, additions.forces.spec, additions.forces.initial};
  InputPort<Eigen::VectorXd> added_position_references{this, additions.position_references.spec,
                                                       additions.position_references.initial};
  InputPort<Eigen::VectorXd> added_speed_references{this, additions.speed_references.spec,
                                                    additions.speed_references.initial};

  ContinuousState<LeggedState> motion{this, {"motion"}, params.initial};
  ContinuousState<FootBristles> bristles{this, {"bristles"}};
  ContinuousState<Eigen::VectorXd> added_q{this, additions.q.spec, additions.q.initial};
  ContinuousState<Eigen::VectorXd> added_u{this, additions.u.spec, additions.u.initial};
  ContinuousState<Eigen::VectorXd> added_z{this, additions.z.spec, additions.z.initial};

  Shared<QuadrupedBody> body{this, "body", QuadrupedBody(loaded_), Uses(motion), &QuadrupedPlant::CalcBody};
  Shared<FootContacts> contacts{this, "contacts", Uses(motion, body, bristles),
                                &QuadrupedPlant::CalcContacts};

  Shared<ExtendedQuadruped> extended{
      this, "extended", additions_,
      Uses(time, motion, added_q, added_u, added_z, added_position_references, added_speed_references),
      &QuadrupedPlant::CalcExtended};

  OutputPort<LeggedState> state{this, {"state"}, Uses(motion), &QuadrupedPlant::CalcState};
  OutputPort<Vec<12>> joint_torque{
      this, {"joint_torque", "N m", kJointElements}, Uses(motion, torque), &QuadrupedPlant::CalcJointTorque};
  Shared<ExtendedRates> rates{
      this, "rates", Uses(motion, body, contacts, joint_torque, external, locks, extended, added_forces),
      &QuadrupedPlant::CalcRates};
  OutputPort<LeggedAcceleration> acceleration{
      this, {"acceleration"}, Uses(rates), &QuadrupedPlant::CalcAcceleration};
  OutputPort<FootForces> foot_forces{this, {"foot_forces"}, Uses(contacts), &QuadrupedPlant::CalcFootForces};
  OutputPort<Vec<4>> foot_depths{
      this, {"foot_depths", "m", kLegElements}, Uses(contacts), &QuadrupedPlant::CalcFootDepths};
  OutputPort<std::array<Vec<3>, kNumLegs>> foot_slips{
      this, {"foot_slips", "m/s", kLegElements}, Uses(contacts), &QuadrupedPlant::CalcFootSlips};
  OutputPort<LeggedEnergy> energy{this, {"energy"}, Uses(body, extended), &QuadrupedPlant::CalcEnergy};
  OutputPort<WrenchEstimate> external_wrench{
      this, {"external_wrench"}, Uses(body, external), &QuadrupedPlant::CalcExternalWrench};
  OutputPort<Vec<12>> external_torque{this,
                                      {"external_torque", "N m", kJointElements},
                                      Uses(body, external),
                                      &QuadrupedPlant::CalcExternalTorque};
  OutputPort<Geometry> geometry{this,
                                {"geometry"},
                                MakeGeometry(),
                                Uses(state, foot_forces, external, extended),
                                &QuadrupedPlant::CalcGeometry};
  OutputPort<Eigen::VectorXd> added_positions{this, {"added_positions"}, added_q};
  OutputPort<Eigen::VectorXd> added_speeds{this, {"added_speeds"}, added_u};
  OutputPort<WrenchEstimate> added_wrench{this,
                                          {"added_wrench"},
                                          Uses(body, contacts, external, extended, rates),
                                          &QuadrupedPlant::CalcAddedWrench};

  TimeDerivative<LeggedState> motion_rate{motion, Uses(motion, acceleration),
                                          &QuadrupedPlant::CalcMotionRate};
  TimeDerivative<FootBristles> bristle_rate{bristles, Uses(contacts), &QuadrupedPlant::CalcBristleRate};
  TimeDerivative<Eigen::VectorXd> added_q_rate{
      added_q, Uses(rates), [](const ExtendedRates& rates_now, Eigen::VectorXd* out) { *out = rates_now.q; }};
  TimeDerivative<Eigen::VectorXd> added_u_rate{
      added_u, Uses(rates), [](const ExtendedRates& rates_now, Eigen::VectorXd* out) { *out = rates_now.u; }};
  TimeDerivative<Eigen::VectorXd> added_z_rate{
      added_z, Uses(rates), [](const ExtendedRates& rates_now, Eigen::VectorXd* out) { *out = rates_now.z; }};

 private:
  static QuadrupedDescription Without(QuadrupedDescription robot, const RigidInertia& part);
  void CalcBody(const LeggedState& x, QuadrupedBody* out) const;
  void CalcContacts(const LeggedState& x, const QuadrupedBody& body, const FootBristles& bristles,
                    FootContacts* out) const;
  LeggedState CalcState(const LeggedState& x) const;
  Vec<12> CalcJointTorque(const LeggedState& x, const Vec<12>& command) const;
  void CalcExtended(double t, const LeggedState& x, const Eigen::VectorXd& q, const Eigen::VectorXd& u,
                    const Eigen::VectorXd& z, const Eigen::VectorXd& position_references,
                    const Eigen::VectorXd& speed_references, ExtendedQuadruped* out) const;
  void CalcRates(const LeggedState& x, const QuadrupedBody& body, const FootContacts& contacts,
                 const Vec<12>& joint_torque, const ExternalForces& external, const JointLocks& locks,
                 const ExtendedQuadruped& extended, const Eigen::VectorXd& added_forces,
                 ExtendedRates* out) const;
  LeggedAcceleration CalcAcceleration(const ExtendedRates& rates_now) const { return rates_now.robot; }
  FootForces CalcFootForces(const FootContacts& contacts) const;
  Vec<4> CalcFootDepths(const FootContacts& contacts) const;
  std::array<Vec<3>, kNumLegs> CalcFootSlips(const FootContacts& contacts) const;
  LeggedEnergy CalcEnergy(const QuadrupedBody& body, const ExtendedQuadruped& extended) const;
  WrenchEstimate CalcExternalWrench(const QuadrupedBody& body, const ExternalForces& external) const;
  Vec<3> ComWithoutPayload(const QuadrupedBody& body) const;
  WrenchEstimate CalcAddedWrench(const QuadrupedBody& body, const FootContacts& contacts,
                                 const ExternalForces& external, const ExtendedQuadruped& extended,
                                 const ExtendedRates& rates) const;
  Vec<12> CalcExternalTorque(const QuadrupedBody& body, const ExternalForces& external) const;
  Geometry MakeGeometry() const;
  void CalcGeometry(const LeggedState& x, const FootForces& feet, const ExternalForces& external,
                    const ExtendedQuadruped& extended, Geometry* out) const;
  LeggedState CalcMotionRate(const LeggedState& x, const LeggedAcceleration& acceleration) const;
  FootBristles CalcBristleRate(const FootContacts& contacts) const;
};

}  // namespace tenon

TENON_DECLARE_SIGNAL(tenon::FootBristles);
TENON_DECLARE_SIGNAL(tenon::LeggedEnergy);
TENON_DECLARE_SIGNAL(tenon::FootContacts);
