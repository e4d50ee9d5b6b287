#pragma once

#include <tenon/plants/cdpr/cdpr_geometry.h>
#include <tenon/plants/cdpr/extended_platform.h>
#include <tenon/plants/cdpr/free_rigid_body.h>
#include <tenon/plants/cdpr/winch.h>
#include <tenon/plants/model/path.h>
#include <tenon/systems/block.h>

namespace tenon {

struct CdprPlantParams {
  CdprDescription robot;
  Vec<3> p_WB = Vec<3>::Zero();   ///< initial position of the CoM [m]
  Vec<3> euler = Vec<3>::Zero();  ///< initial roll, pitch, yaw [rad]
  Vec<3> v_W = Vec<3>::Zero();    ///< initial velocity [m/s]
  Vec<3> w_W = Vec<3>::Zero();    ///< initial angular velocity [rad/s]
  CableVector
      initial_tension;  ///< initial tension of each cable [N], from which rest lengths and motors follow
  CableVector homed_length{};  ///< initial measured lengths [m]; empty: from attachments to anchors
  double gravity = kGravity;   ///< [m/s^2]
  bool lock_winches = false;   ///< locks the drums, so that rest lengths are constant
  ExtendCdpr extend = {};      ///< adds to the platform in Simbody, see CdprPlant; nothing by default

  /// Throws ParameterError, also if the robot's description is not valid.
  void Validate() const;
};

/// A cable-driven parallel robot: a rigid platform, 2 or more elastic cables, one winch each, and springs.
///
/// Only `command` must be connected; negative commands count as 0. NaN as the reference of a drive of an
/// added joint stands for that of the drive's own parameters, see AttachedBody. `wrench` acts about the CoM,
/// and `acceleration` is that of the CoM. `added_wrench` is that of the additions on the platform about its
/// CoM. `motor_tension` is T_m at the drum, and `reel_speed` dl0/dt on the radius at the start in torque
/// mode, else unused.
///
/// **Platform** (Morlando 2023, eqs. (3.7) and (3.8), there in terms of L):
///
///     m a = sum_i T_i e_i + m g + f_ext,   I alpha + w x I w = sum_i (R_WB r_i) x T_i e_i + tau_ext,
///
/// with e_i the direction from attachment to anchor; r_i is where the cable leaves its pulley if pulleys are
/// on the platform. The length of the quaternion q does not affect the motion; the term 5 (1 - |q|^2) q in
/// its derivative restores unit length, so that equilibria are isolated points.
///
/// **Cables** follow CableStatics; by default they are straight springs if longer than their rest length l0.
/// The material's damping time, damping / EA, determines their damping in the direction of the cable's end:
///
///     T = max(0, T_e + c (dl/dt - dl0/dt)),   c = (damping / EA) dT_e/dl;
///     straight  T_e = k (l - l0) and c = damping / l0 if l > l0, else both 0;   k = EA / l0.
///
/// The damping makes T jump when a slack cable becomes taut at a nonzero rate. A cable with mass sags, has a
/// larger tension at its anchor than at its attachment, and is never without tension. It is in static
/// equilibrium at every instant. Not modelled: the cable's own oscillation, and the friction of pulleys (see
/// WinchErrors).
///
/// **Springs** between frame and platform act as platform_springs.h says: in the equations above their wrench
/// adds to that of the cables, and `energy` counts theirs as elastic. Not modelled: their mass and damping.
///
/// **Moving anchors** have the places and velocities of their paths, whatever the cables pull (see
/// AnchorPath): cranes and gantries are stiff. The anchor's velocity v_a counts in dl/dt = e . (v_a -
/// v_attachment), and the anchors do the work sum_i T_i e_i . v_a on the robot (without sag and pulleys,
/// where e_i is also the direction of the force on the anchor). Posts are drawn below them.
///
/// **Winches.** The motor follows the command u, d T_m/dt = (max(0, u) - T_m) / time constant, u limited by
/// the differential, see DifferentialProperties. The dynamics of l0 under T_m and T are in winch.h. On a drum
/// with layers `cables.length` and `cables.rest_length` convert its turns by the radius at the start. The
/// measured lengths at the start are `homed_length`, as after homing with a model of the robot.
///
/// **Faults.** The drum of a winch that sticks does not turn, dl0/dt = 0, so that T = max(0, k (l - l0) + c
/// dl/dt); a broken cable has T = 0 at any length, and its drum does not turn either. The motors are not
/// affected. In torque mode the speed of a stuck drum decays with the motor's time constant.
///
/// **Payload.** When the signal changes, mass and inertia change at once and exactly while pose and velocity
/// do not: an added mass has the velocity of its point of attachment. Use a sampled source, so that the
/// signal changes at ticks and no integration step contains the change.
///
/// **Additions.** The function `extend` adds bodies, joints, forces, constraints and contacts to the platform
/// in Simbody; robot_multibody.h is the guide, cdpr_multibody.h names the body, and attached_bodies.h adds
/// bodies from parameters. Simbody's forward dynamics then take the place of the equations under
/// **Platform**; those of cables, winches and faults stay. The coordinates, speeds and auxiliary variables of
/// the additions are the states added_q, added_u and added_z. `energy` includes the additions, `added_wrench`
/// is
///
///     f = m a - m g - sum_i T_i e_i - f_ext,   t = I alpha + w x I w - sum_i (R_WB r_i) x T_i e_i - tau_ext,
///
/// with the payload as a part of the platform; it is 0 without additions. The initial tensions do not carry
/// the additions, whose weight the cables take up from the start on. Controllers do not know the additions
/// unless they measure `added_wrench`, and the limits of CdprMonitor do not include them. Without `extend`,
/// the closed form of free_rigid_body.h, which is faster, computes the accelerations, and these states are
/// empty.
///
/// At the start the cables have the tension `initial_tension`, straight l0 = l / (1 + T / EA), and so have
/// the motors. The constructor throws ParameterError where CalcRestLength throws. Not modelled: speed limits
/// of the winches.
///
/// Throws RunError where CalcCableStatics() does, if a drum is empty, if the command does not have one entry
/// per cable, if the faults have neither one entry per cable nor none, if the payload's mass is negative, and
/// if the number of added forces or references is wrong.
class CdprPlant final : public LeafSystem<CdprPlantParams> {
 public:
  using LeafSystem::LeafSystem;

  /// State of the cables, shared by several calculations.
  struct CableForces {
    CableSignals signals;
    std::vector<CableStatics> statics{};
    CableVector reeling{};    ///< radius of each cable on its drum, relative to the initial radius
    PlatformWrench wrench{};  ///< wrench of all cables and springs, about the CoM
    double energy = 0;        ///< elastic energy of both [J]
    double potential = 0;     ///< potential energy of the cables' weight [J]
  };
  /// Cables and encoder offsets at the start, after homing.
  struct Start {
    Eigen::VectorXd rest_length;                  ///< [m]
    Eigen::VectorXd length_offset;                ///< true minus measured length, and rest length [m]
    std::vector<double> drum_angle, drum_radius;  ///< angles and radii of drums with layers [rad, m]
    std::vector<int> partner;                     ///< partner of each cable at a differential; -1: none
  };
  const Start start = StartOf(params);
  const MovingAnchors anchors{params.robot};

 private:
  const ExtendedRobot additions_ =
      ExtendedPlatform(params.robot, params.gravity, params.extend, InitialPlatform(params));

 public:
  /// Names, units and initial values of the states and inputs of the additions.
  const ExtendedRobot::Additions& additions = additions_.additions();

  InputPort<CableVector> command{this, {"command", "N"}};
  InputPort<Payload> payload{this, {"payload"}, Payload{}};
  InputPort<PlatformWrench> wrench{this, {"wrench"}, PlatformWrench{}};
  InputPort<CableFaults> faults{this, {"faults"}, CableFaults{}};
  InputPort<Eigen::VectorXd> added_forces{this, additions.forces.spec, additions.forces.initial};
  InputPort<Eigen::VectorXd> added_position_references{this, additions.position_references.spec,
                                                       additions.position_references.initial};
  InputPort<Eigen::VectorXd> added_speed_references{this, additions.speed_references.spec,
                                                    additions.speed_references.initial};

  ContinuousState<PlatformState> platform_state{this, {"platform_state"}, InitialPlatform(params)};
  ContinuousState<Eigen::VectorXd> rest_length{this, {"rest_length", "m"}, start.rest_length};
  ContinuousState<Eigen::VectorXd> motor_tension{this, {"motor_tension", "N"}, params.initial_tension};
  ContinuousState<Eigen::VectorXd> reel_speed{
      this, {"reel_speed", "m/s"}, Eigen::VectorXd::Zero(params.robot.num_cables())};
  ContinuousState<Eigen::VectorXd> added_q{this, additions.q.spec, additions.q.initial};
  ContinuousState<Eigen::VectorXd> added_u{this, additions.u.spec, additions.u.initial};
  ContinuousState<Eigen::VectorXd> added_z{this, additions.z.spec, additions.z.initial};

  Shared<CableForces> cable_forces{this, "cable_forces", NoForces(params.robot.num_cables()),
                                   Uses(time, platform_state, rest_length, motor_tension, reel_speed, faults),
                                   &CdprPlant::CalcCableForces};
  Shared<FreeRigidBody> body{this, "body", FreeRigidBody(params.robot.mass, params.robot.inertia_B),
                             Uses(platform_state, cable_forces, payload, wrench), &CdprPlant::CalcBody};
  Shared<ExtendedRobot> extended{this, "extended", additions_,
                                 Uses(time, platform_state, added_q, added_u, added_z,
                                      added_position_references, added_speed_references),
                                 &CdprPlant::CalcExtended};
  Shared<PlatformRates> rates{
      this, "rates", Uses(platform_state, cable_forces, payload, wrench, body, extended, added_forces),
      &CdprPlant::CalcRates};

  OutputPort<PlatformState> platform{this, {"platform"}, Uses(platform_state), &CdprPlant::CalcPlatform};
  OutputPort<Vec<3>> euler{
      this, {"euler", "rad", "roll, pitch, yaw"}, Uses(platform_state), &CdprPlant::CalcEuler};
  OutputPort<PlatformAcceleration> acceleration{
      this, {"acceleration"}, Uses(rates), &CdprPlant::CalcAcceleration};
  OutputPort<CableSignals> cables{this,
                                  {"cables"},
                                  CableSignals::Zero(params.robot.num_cables()),
                                  Uses(cable_forces),
                                  &CdprPlant::CalcCables};
  OutputPort<CdprEnergy> energy{
      this, {"energy"}, Uses(platform_state, cable_forces, body, payload, extended), &CdprPlant::CalcEnergy};
  OutputPort<Geometry> geometry{this,
                                {"geometry"},
                                MakeGeometry(),
                                Uses(platform, cable_forces, payload, wrench, extended),
                                &CdprPlant::CalcGeometry};
  OutputPort<Eigen::VectorXd> added_positions{this, {"added_positions"}, added_q};
  OutputPort<Eigen::VectorXd> added_speeds{this, {"added_speeds"}, added_u};
  OutputPort<PlatformWrench> added_wrench{
      this,
      {"added_wrench"},
      Uses(platform_state, cable_forces, payload, wrench, extended, rates),
      &CdprPlant::CalcAddedWrench};

  TimeDerivative<PlatformState> platform_rate{platform_state, Uses(platform_state, rates),
                                              &CdprPlant::CalcPlatformRate};
  TimeDerivative<Eigen::VectorXd> rest_length_rate{
      rest_length, Uses(cable_forces, motor_tension, reel_speed, faults), &CdprPlant::CalcRestLengthRate};
  TimeDerivative<Eigen::VectorXd> motor_tension_rate{motor_tension, Uses(motor_tension, command),
                                                     &CdprPlant::CalcMotorTensionRate};
  TimeDerivative<Eigen::VectorXd> reel_acceleration{
      reel_speed, Uses(cable_forces, motor_tension, reel_speed, faults), &CdprPlant::CalcReelAcceleration};
  TimeDerivative<Eigen::VectorXd> added_q_rate{
      added_q, Uses(rates), [](const PlatformRates& rates_now, Eigen::VectorXd* out) { *out = rates_now.q; }};
  TimeDerivative<Eigen::VectorXd> added_u_rate{
      added_u, Uses(rates), [](const PlatformRates& rates_now, Eigen::VectorXd* out) { *out = rates_now.u; }};
  TimeDerivative<Eigen::VectorXd> added_z_rate{
      added_z, Uses(rates), [](const PlatformRates& rates_now, Eigen::VectorXd* out) { *out = rates_now.z; }};

 private:
  static PlatformState InitialPlatform(const CdprPlantParams& params);
  static Start StartOf(const CdprPlantParams& params);
  static CableForces NoForces(int num_cables);
  WinchMotion MotionOf(int cable, double motor_tension, double reel_speed, double reeling,
                       const CableFaults& faults) const {
    return {motor_tension, reel_speed, reeling, params.lock_winches || faults.is_stuck(cable)};
  }

  void CalcCableForces(double time, const PlatformState& x, const Eigen::VectorXd& rest_length,
                       const Eigen::VectorXd& motor_tension, const Eigen::VectorXd& reel_speed,
                       const CableFaults& faults, CableForces* out) const;
  void CalcBody(const PlatformState& x, const CableForces& cables, const Payload& payload,
                const PlatformWrench& wrench, FreeRigidBody* out) const;
  void CalcExtended(double time, const PlatformState& x, const Eigen::VectorXd& q, const Eigen::VectorXd& u,
                    const Eigen::VectorXd& z, const Eigen::VectorXd& position_references,
                    const Eigen::VectorXd& speed_references, ExtendedRobot* out) const {
    if (out->exists()) out->SetState(time, {x}, q, u, z, position_references, speed_references);
  }
  void CalcRates(const PlatformState& x, const CableForces& cables, const Payload& payload,
                 const PlatformWrench& wrench, const FreeRigidBody& body, const ExtendedRobot& extended,
                 const Eigen::VectorXd& added_forces, PlatformRates* out) const;
  PlatformState CalcPlatform(const PlatformState& x) const;
  Vec<3> CalcEuler(const PlatformState& x) const;
  PlatformAcceleration CalcAcceleration(const PlatformRates& rates_now) const { return rates_now.platform; }
  void CalcCables(const CableForces& cables_now, CableSignals* out) const { *out = cables_now.signals; }
  CdprEnergy CalcEnergy(const PlatformState& x, const CableForces& cables, const FreeRigidBody& body,
                        const Payload& payload, const ExtendedRobot& extended) const;
  Geometry MakeGeometry() const;
  void CalcGeometry(const PlatformState& x, const CableForces& cables, const Payload& payload,
                    const PlatformWrench& wrench, const ExtendedRobot& extended, Geometry* out) const;
  PlatformWrench CalcAddedWrench(const PlatformState& x, const CableForces& cables, const Payload& payload,
                                 const PlatformWrench& wrench, const ExtendedRobot& extended,
                                 const PlatformRates& rates) const;
  PlatformState CalcPlatformRate(const PlatformState& x, const PlatformRates& rates) const;
  void CalcRestLengthRate(const CableForces& cables, const Eigen::VectorXd& motor_tension,
                          const Eigen::VectorXd& reel_speed, const CableFaults& faults,
                          Eigen::VectorXd* rate) const;
  void CalcMotorTensionRate(const Eigen::VectorXd& motor_tension, const CableVector& command,
                            Eigen::VectorXd* rate) const;
  void CalcReelAcceleration(const CableForces& cables, const Eigen::VectorXd& motor_tension,
                            const Eigen::VectorXd& reel_speed, const CableFaults& faults,
                            Eigen::VectorXd* acceleration) const;
};

}  // namespace tenon
