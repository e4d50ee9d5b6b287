#include <tenon/plants/legged/quadruped_plant.h>

#include <Eigen/Geometry>
#include <fmt/format.h>

namespace tenon {
namespace {

constexpr double kNormRate = 5;         // decay rate of the error of the quaternion's length [1/s]
constexpr double kFrictionSpeed = 0.1;  // speed below which Coulomb friction is smoothed [rad/s]

void CheckBody(const ExternalForce& force) {
  if (force.body < 0 || force.body > kNumJoints)
    throw RunError(
        fmt::format("an external force acts on body {}; give 0 for the trunk or 1 to {} for the body that a "
                    "joint moves",
                    force.body, kNumJoints));
}

/// Friction and end stops of a joint.
double PassiveTorque(double q, double qd, const JointDescription& joint, const DriveProperties& drive) {
  double torque = -drive.damping * qd;
  if (drive.friction > 0) torque -= drive.friction * std::tanh(qd / kFrictionSpeed);
  const double above = q - joint.upper, below = joint.lower - q;
  if (above > 0) torque -= drive.stop_stiffness * above * std::max(0.0, 1 + drive.stop_dissipation * qd);
  if (below > 0) torque += drive.stop_stiffness * below * std::max(0.0, 1 - drive.stop_dissipation * qd);
  return torque;
}

}  // namespace

double DriveTorque(double command, double qd, const JointDescription& joint, const DriveProperties& drive,
                   bool limit_speed) {
  double upper = joint.torque_limit, lower = -joint.torque_limit;
  if (limit_speed) {
    const double fall = joint.speed_limit * (1 - drive.full_torque_speed_ratio);
    upper = std::clamp(joint.torque_limit * (joint.speed_limit - qd) / fall, lower, upper);
    lower = std::clamp(-joint.torque_limit * (joint.speed_limit + qd) / fall, lower, upper);
  }
  if (command > upper) return upper;  // propagates NaN
  return command < lower ? lower : command;
}

void QuadrupedPlantParams::Validate() const {
  robot.CheckMass();
  if (!(std::isfinite(payload.mass) && payload.com.allFinite() && payload.inertia.allFinite()))
    throw ParameterError(
        "the payload is not finite; give mass, centre of mass and inertia in SI units, 0 kg for none");
  if (robot.foot_radius > Terrain::kMaxRadius)
    throw ParameterError(
        fmt::format("the feet of '{}' have a radius of {} m, but the terrain takes at most {} m", robot.name,
                    robot.foot_radius, Terrain::kMaxRadius));
  if (!internal::IsFinite(initial) || initial.q_WB.norm() == 0)
    throw ParameterError(
        "the initial state has entries that are not finite, or a quaternion of length 0; give "
        "all in SI units and a unit quaternion");
  if (!std::isfinite(gravity))
    throw ParameterError(fmt::format("gravity is {} but must be finite; give m/s^2", gravity));
  terrain.Validate();
}

void QuadrupedPlant::CalcBody(const LeggedState& x, QuadrupedBody* out) const {
  out->SetState(x);
}

void QuadrupedPlant::CalcContacts(const LeggedState& x, const QuadrupedBody& body,
                                  const FootBristles& bristles, FootContacts* out) const {
  body_contact_.CalcForces(body, x, &out->bodies);
  for (int leg = 0; leg < kNumLegs; ++leg)
    out->feet[leg] = CalcFootContact(terrain, params.robot.contact, params.robot.foot_radius, body.Foot(leg),
                                     bristles.z.segment<2>(2 * leg));
}

LeggedState QuadrupedPlant::CalcState(const LeggedState& x) const {
  LeggedState state = x;
  state.q_WB.normalize();
  return state;
}

Vec<12> QuadrupedPlant::CalcJointTorque(const LeggedState& x, const Vec<12>& command) const {
  Vec<12> torque;
  for (int j = 0; j < kNumJoints; ++j)
    torque[j] =
        DriveTorque(command[j], x.qd[j], params.robot.joint(j), params.robot.drive, params.limit_speed);
  return torque;
}

void QuadrupedPlant::CalcExtended(double t, const LeggedState& x, const Eigen::VectorXd& q,
                                  const Eigen::VectorXd& u, const Eigen::VectorXd& z,
                                  const Eigen::VectorXd& position_references,
                                  const Eigen::VectorXd& speed_references, ExtendedQuadruped* out) const {
  if (out->exists())
    out->SetState(t, ExtendedQuadruped::MotionOf(x), q, u, z, position_references, speed_references);
}

void QuadrupedPlant::CalcRates(const LeggedState& x, const QuadrupedBody& body, const FootContacts& contacts,
                               const Vec<12>& joint_torque, const ExternalForces& external,
                               const JointLocks& locks, const ExtendedQuadruped& extended,
                               const Eigen::VectorXd& added_forces, ExtendedRates* out) const {
  std::array<PointForce, std::tuple_size_v<decltype(contacts.bodies.at)> + kNumLegs + kMaxExternalForces>
      forces;
  std::size_t count = 0;
  for (std::size_t leg = 0; leg < kNumLegs; ++leg) {
    const FootContact& foot = contacts.feet[leg];
    if (foot.depth > 0)
      forces[count++] = {static_cast<int>(kJointsPerLeg * (leg + 1)), foot.p_W, foot.force_W};
  }
  for (std::size_t i = 0; i < contacts.bodies.count; ++i) forces[count++] = contacts.bodies.at[i];
  for (const ExternalForce& force : external) {
    CheckBody(force);
    if (!force.force_W.isZero(0) || !force.torque_W.isZero(0))
      forces[count++] = {force.body, body.Position(force.body, force.p_B), force.force_W, force.torque_W};
  }
  Vec<12> torque;
  for (int j = 0; j < kNumJoints; ++j) {
    torque[j] = joint_torque[j] + PassiveTorque(x.q[j], x.qd[j], params.robot.joint(j), params.robot.drive);
    if (locks.stiffness[j] > 0)
      torque[j] -= locks.stiffness[j] * (x.q[j] - locks.angle[j]) + locks.damping[j] * x.qd[j];
  }
  if (!extended.exists()) {
    out->robot = body.Acceleration(torque, {forces.data(), count}, params.gravity);
    return;
  }
  extended.CalcRates(torque, {forces.data(), count}, added_forces, out);
}

FootForces QuadrupedPlant::CalcFootForces(const FootContacts& contacts) const {
  FootForces forces;
  for (int leg = 0; leg < kNumLegs; ++leg) forces[leg] = contacts.feet[leg].force_W;
  return forces;
}

Vec<4> QuadrupedPlant::CalcFootDepths(const FootContacts& contacts) const {
  Vec<4> depths;
  for (int leg = 0; leg < kNumLegs; ++leg) depths[leg] = contacts.feet[leg].depth;
  return depths;
}

std::array<Vec<3>, kNumLegs> QuadrupedPlant::CalcFootSlips(const FootContacts& contacts) const {
  std::array<Vec<3>, kNumLegs> slips;
  for (std::size_t leg = 0; leg < kNumLegs; ++leg) slips[leg] = contacts.feet[leg].slip_W;
  return slips;
}

LeggedEnergy QuadrupedPlant::CalcEnergy(const QuadrupedBody& body, const ExtendedQuadruped& extended) const {
  if (extended.exists()) return {extended.KineticEnergy(), extended.PotentialEnergy()};
  return {body.KineticEnergy(), params.gravity * loaded_.mass() * body.Com()[2]};
}

Vec<3> QuadrupedPlant::ComWithoutPayload(const QuadrupedBody& body) const {
  const RigidInertia& payload = params.payload;
  return (loaded_.mass() * body.Com() - payload.mass * body.Position(0, payload.com)) /
         (loaded_.mass() - payload.mass);
}

WrenchEstimate QuadrupedPlant::CalcExternalWrench(const QuadrupedBody& body,
                                                  const ExternalForces& external) const {
  const RigidInertia& payload = params.payload;
  const Vec<3> payload_W = body.Position(0, payload.com);
  const Vec<3> com = ComWithoutPayload(body);
  WrenchEstimate wrench;
  wrench.force_W[2] = -payload.mass * params.gravity;
  wrench.torque_W = (payload_W - com).cross(wrench.force_W);
  for (const ExternalForce& force : external) {
    CheckBody(force);
    wrench.force_W += force.force_W;
    wrench.torque_W += force.torque_W + (body.Position(force.body, force.p_B) - com).cross(force.force_W);
  }
  return wrench;
}

WrenchEstimate QuadrupedPlant::CalcAddedWrench(const QuadrupedBody& body, const FootContacts& contacts,
                                               const ExternalForces& external,
                                               const ExtendedQuadruped& extended,
                                               const ExtendedRates& rates) const {
  if (!extended.exists()) return {};
  const Vec<3> com = ComWithoutPayload(body);
  const WrenchEstimate others = CalcExternalWrench(body, external);  // with the payload's weight
  WrenchEstimate wrench = extended.MomentumRate(rates.robot, com);
  wrench.force_W[2] += (loaded_.mass() - params.payload.mass) * params.gravity;
  wrench.force_W -= others.force_W;
  wrench.torque_W -= others.torque_W;
  for (const FootContact& foot : contacts.feet) {
    wrench.force_W -= foot.force_W;
    wrench.torque_W -= (foot.p_W - com).cross(foot.force_W);
  }
  for (std::size_t i = 0; i < contacts.bodies.count; ++i) {
    const PointForce& on_body = contacts.bodies.at[i];
    wrench.force_W -= on_body.force_W;
    wrench.torque_W -= on_body.torque_W + (on_body.p_W - com).cross(on_body.force_W);
  }
  return wrench;
}

Vec<12> QuadrupedPlant::CalcExternalTorque(const QuadrupedBody& body, const ExternalForces& external) const {
  Vec<12> torque = Vec<12>::Zero();
  for (const ExternalForce& force : external) {
    CheckBody(force);
    if (force.body == 0) continue;
    const Vec<3> p_W = body.Position(force.body, force.p_B);
    const int last = force.body - 1;  // joint of the body, after the other joints between it and the trunk
    for (int j = last - last % kJointsPerLeg; j <= last; ++j) {
      const Vec<3> origin = body.Position(1 + j, Vec<3>::Zero());
      const Vec<3> axis = body.Position(1 + j, params.robot.joint(j).axis) - origin;
      torque[j] += axis.dot(force.torque_W + (p_W - origin).cross(force.force_W));
    }
  }
  return torque;
}

QuadrupedDescription QuadrupedPlant::Without(QuadrupedDescription robot, const RigidInertia& part) {
  if (part.mass > 0) robot.trunk = robot.trunk + RigidInertia{-part.mass, part.com, -part.inertia};
  return robot;
}

Geometry QuadrupedPlant::MakeGeometry() const {
  Geometry shapes = MakeQuadrupedGeometry(bare_robot, params.payload, params.terrain);
  shapes.insert(shapes.end(), additions.shapes.begin(), additions.shapes.end());
  return shapes;
}

void QuadrupedPlant::CalcGeometry(const LeggedState& x, const FootForces& feet,
                                  const ExternalForces& external, const ExtendedQuadruped& extended,
                                  Geometry* out) const {
  MoveQuadrupedGeometry(bare_robot, params.payload, x, feet, external, out);
  if (extended.exists()) extended.MoveShapes(out->size() - additions.shapes.size(), out);
}

LeggedState QuadrupedPlant::CalcMotionRate(const LeggedState& x,
                                           const LeggedAcceleration& acceleration) const {
  return {x.v_W,
          QuaternionRate(x.q_WB, x.w_W) + kNormRate * (1 - x.q_WB.squaredNorm()) * x.q_WB,
          x.qd,
          acceleration.a_W,
          acceleration.alpha_W,
          acceleration.qdd};
}

FootBristles QuadrupedPlant::CalcBristleRate(const FootContacts& contacts) const {
  FootBristles rate;
  for (int leg = 0; leg < kNumLegs; ++leg) rate.z.segment<2>(2 * leg) = contacts.feet[leg].bristle_rate;
  return rate;
}

}  // namespace tenon

TENON_DEFINE_SIGNAL(tenon::FootBristles);
TENON_DEFINE_SIGNAL(tenon::LeggedEnergy);
TENON_DEFINE_SIGNAL(tenon::FootContacts);
