#pragma once

#include <tenon/plants/legged/foot_contact.h>
#include <tenon/plants/legged/quadruped_body.h>
#include <tenon/plants/legged/quadruped_geometry.h>
#include <tenon/plants/model/gravity.h>
#include <tenon/plants/signals/disturbance_signals.h>
#include <tenon/plants/signals/legged_signals.h>
#include <tenon/plants/surroundings/terrain.h>
#include <tenon/systems/framework/block/ports.h>
#include <tenon/systems/framework/block/state.h>
#include <tenon/systems/framework/block/system.h>

#include <array>

namespace tenon {

struct QuadrupedPlantParams {
  QuadrupedDescription robot;
  RigidInertia payload;  ///< fixed to the trunk, in B; none by default
  TerrainParams terrain;
  LeggedState initial;
  double gravity = kGravity;  ///< [m/s^2]
  bool limit_speed = true;    ///< the drives' torque falls with speed

  void Validate() const;  ///< throws ParameterError
};

/// What a drive gives of a command at a joint's speed qd [N m, rad/s]: see QuadrupedPlant. Not a number stays
/// not a number.
double DriveTorque(double command, double qd, const JointDescription& joint, const DriveProperties& drive,
                   bool limit_speed = true);

/// The bristles of the feet, see foot_contact.h.
struct FootBristles {
  Vec<8> z = Vec<8>::Zero();  ///< two for each leg [m]
  static FieldList Fields() { return {{"z", &FootBristles::z, "m"}}; }
};

/// How the feet stand on the ground.
struct FootContacts {
  std::array<FootContact, kNumLegs> feet;
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

/// A quadruped on terrain: rigid bodies in Simbody (quadruped_body.h), feet that stick (foot_contact.h).
///
///     ports in   torque           command to the joints' drives [N m]
///                external         up to eight forces and torques on the robot; none if not connected
///                locks            joints that are stuck, see joint_lock.h; none if not connected
///     ports out  state            pose and velocity of the trunk, joint angles and speeds
///                acceleration     of B's origin and of the joints, as an inertial unit needs it
///                foot_forces      of the ground on each foot [N]
///                foot_depths      of each foot in the ground [m]
///                foot_slips       velocity of each foot's point in contact along the ground [m/s]
///                joint_torque     what the drives give after their limits [N m]
///                energy           kinetic, potential
///                external_wrench  of `external` and the payload's weight, about the CoM without payload
///                external_torque  of `external` on the joints [N m]
///                geometry         what it looks like, terrain included
///
/// **Drives.** The torque is the command within the torque limit. With `limit_speed` it is also below the
/// torque-speed line of the motor: full torque up to a ratio r of the speed limit w, then falling linearly,
/// 0 at the limit, and braking above,
///
///     tau <= limit min(1, (w - qd) / ((1 - r) w)), not below -limit, and the mirror image for qd < 0.
///
/// Friction is viscous plus Coulomb's, the latter smooth below 0.1 rad/s. End stops push back with
/// k e max(0, 1 + c e'), e being the angle beyond the range: stops without jumps, which dissipate.
/// Rotor inertia is seen by the joint alone, not by the trunk as gyroscopic torque.
///
/// The quaternion's length has no meaning for the motion; 5 (1 - |q|^2) q in its derivative brings it to 1.
/// Only feet touch the ground: a fallen robot sinks into it, so a run should end at a fall.
///
/// **Integration.** An explicit method with steps by tolerance, since impacts need short steps. Order 2 with
/// rtol = 1e-2 and absolute tolerances of 1e-4 m and rad, 1e-2 m/s and rad/s, 1e-6 m for the bristles is
/// within 0.05 mm of the exact motion in a landing from 10 cm and in a trot under joint PD at 1 kHz (feet's
/// forces: 0.4 N rms), with 3 and 6 evaluations per ms; standing takes 2. Ten times tighter ones bring no
/// more there: what is left is the foot that touches down late in a step, unseen. Order 3 with all tolerances
/// a hundredth of those is within 0.01 mm of the trot, with 14 evaluations per ms. A shank under load decays
/// at up to 4000 /s, so that stability holds the steps of Method::kErk at half a millisecond in that trot;
/// kStabilized of order 2, with 1e-3 m, 1e-1 m/s and 1e-5 m, takes one of a millisecond, 3 evaluations, and
/// is within 0.17 mm. A foot that slides is stiff, at the rate of its speed over z_max, and friction sees
/// every error of its bristle: sliding at 1 m/s, it comes out 0.3 % too small. z_max has a lower bound, so
/// that ground may be as slippery as one likes.
///
/// Throws RunError for a force on a body that is not there.
class QuadrupedPlant final : public LeafSystem<QuadrupedPlantParams> {
 public:
  using LeafSystem::LeafSystem;
  const Terrain terrain{params.terrain};

 private:
  const QuadrupedDescription loaded_{WithPayload(params.robot, params.payload)};

 public:
  InputPort<Vec<12>> torque{this, {"torque", "N m"}};
  InputPort<ExternalForces> external{this, {"external"}, ExternalForces{}};
  InputPort<JointLocks> locks{this, {"locks"}, JointLocks{}};

  ContinuousState<LeggedState> motion{this, {"motion"}, params.initial};
  ContinuousState<FootBristles> bristles{this, {"bristles"}};

  Shared<QuadrupedBody> body{this, "body", QuadrupedBody(loaded_), Uses(motion), &QuadrupedPlant::CalcBody};
  Shared<FootContacts> contacts{this, "contacts", Uses(body, bristles), &QuadrupedPlant::CalcContacts};

  OutputPort<LeggedState> state{this, {"state"}, Uses(motion), &QuadrupedPlant::CalcState};
  OutputPort<Vec<12>> joint_torque{
      this, {"joint_torque", "N m", kJointElements}, Uses(motion, torque), &QuadrupedPlant::CalcJointTorque};
  OutputPort<LeggedAcceleration> acceleration{this,
                                              {"acceleration"},
                                              Uses(motion, body, contacts, joint_torque, external, locks),
                                              &QuadrupedPlant::CalcAcceleration};
  OutputPort<FootForces> foot_forces{this, {"foot_forces"}, Uses(contacts), &QuadrupedPlant::CalcFootForces};
  OutputPort<Vec<4>> foot_depths{
      this, {"foot_depths", "m", kLegElements}, Uses(contacts), &QuadrupedPlant::CalcFootDepths};
  OutputPort<std::array<Vec<3>, kNumLegs>> foot_slips{
      this, {"foot_slips", "m/s", kLegElements}, Uses(contacts), &QuadrupedPlant::CalcFootSlips};
  OutputPort<LeggedEnergy> energy{this, {"energy"}, Uses(body), &QuadrupedPlant::CalcEnergy};
  OutputPort<WrenchEstimate> external_wrench{
      this, {"external_wrench"}, Uses(body, external), &QuadrupedPlant::CalcExternalWrench};
  OutputPort<Vec<12>> external_torque{this,
                                      {"external_torque", "N m", kJointElements},
                                      Uses(body, external),
                                      &QuadrupedPlant::CalcExternalTorque};
  OutputPort<Geometry> geometry{this,
                                {"geometry"},
                                MakeQuadrupedGeometry(params.robot, params.payload, params.terrain),
                                Uses(state, foot_forces, external),
                                &QuadrupedPlant::CalcGeometry};

  TimeDerivative<LeggedState> motion_rate{motion, Uses(motion, acceleration),
                                          &QuadrupedPlant::CalcMotionRate};
  TimeDerivative<FootBristles> bristle_rate{bristles, Uses(contacts), &QuadrupedPlant::CalcBristleRate};

 private:
  void CalcBody(const LeggedState& x, QuadrupedBody* out) const;
  void CalcContacts(const QuadrupedBody& body, const FootBristles& bristles, FootContacts* out) const;
  LeggedState CalcState(const LeggedState& x) const;
  Vec<12> CalcJointTorque(const LeggedState& x, const Vec<12>& command) const;
  LeggedAcceleration CalcAcceleration(const LeggedState& x, const QuadrupedBody& body,
                                      const FootContacts& contacts, const Vec<12>& joint_torque,
                                      const ExternalForces& external, const JointLocks& locks) const;
  FootForces CalcFootForces(const FootContacts& contacts) const;
  Vec<4> CalcFootDepths(const FootContacts& contacts) const;
  std::array<Vec<3>, kNumLegs> CalcFootSlips(const FootContacts& contacts) const;
  LeggedEnergy CalcEnergy(const QuadrupedBody& body) const;
  WrenchEstimate CalcExternalWrench(const QuadrupedBody& body, const ExternalForces& external) const;
  Vec<12> CalcExternalTorque(const QuadrupedBody& body, const ExternalForces& external) const;
  void CalcGeometry(const LeggedState& x, const FootForces& feet, const ExternalForces& external,
                    Geometry* out) const;
  LeggedState CalcMotionRate(const LeggedState& x, const LeggedAcceleration& acceleration) const;
  FootBristles CalcBristleRate(const FootContacts& contacts) const;
};

}  // namespace tenon

TENON_DECLARE_SIGNAL(tenon::FootBristles);
TENON_DECLARE_SIGNAL(tenon::LeggedEnergy);
TENON_DECLARE_SIGNAL(tenon::FootContacts);
