#include <tenon/plants/cdpr/cdpr_plant.h>
#include <tenon/plants/model/platform_springs.h>
#include <tenon/plants/signals/euler.h>

#include <fmt/format.h>

namespace tenon {
namespace {

constexpr double kNormRate = 5;  // rate at which the quaternion's length returns to 1 [1/s]

void CheckFinite(const char* name, const Vec<3>& v) {
  if (!v.allFinite())
    throw ParameterError(
        fmt::format("{} is ({}, {}, {}); give three finite numbers", name, v[0], v[1], v[2]));
}

PlatformWrench Sum(const PlatformWrench& a, const PlatformWrench& b) {
  return {a.force_W + b.force_W, a.torque_W + b.torque_W};
}

}  // namespace

void CdprPlantParams::Validate() const {
  robot.Validate();
  CheckFinite("p_WB", p_WB);
  CheckFinite("euler", euler);
  CheckFinite("v_W", v_W);
  CheckFinite("w_W", w_W);
  if (!std::isfinite(gravity)) throw ParameterError(fmt::format("gravity is {}; give m/s^2", gravity));
  if (robot.on_table && (gravity != 0 || extend))
    throw ParameterError(
        fmt::format("robot '{}' slides on a table, which carries its weight; give gravity 0, attach no "
                    "bodies to it, and do not run it on Simbody's dynamics",
                    robot.name));
  if (gravity < 0 && robot.cable.mass_per_length > 0)
    throw ParameterError(
        fmt::format("gravity is {} m/s^2, but cables with mass hang downwards; give 0 or more", gravity));
  if (initial_tension.size() != robot.num_cables())
    throw ParameterError(
        fmt::format("initial_tension has {} entries but the robot '{}' has {} cables; give one tension each",
                    initial_tension.size(), robot.name, robot.num_cables()));
  if (homed_length.size() != 0 && !(homed_length.size() == robot.num_cables() && homed_length.allFinite()))
    throw ParameterError(fmt::format(
        "homed_length must have one finite length for each of the {} cables of robot '{}', or none at all",
        robot.num_cables(), robot.name));
  for (int i = 0; i < robot.num_cables(); ++i) {
    if (!(std::isfinite(initial_tension[i]) && initial_tension[i] >= 0))
      throw ParameterError(fmt::format(
          "initial_tension of cable {} is {} N; a cable cannot push, give 0 or more", i, initial_tension[i]));
    const CableDescription& cable = robot.cables[i];
    if (cable.anchor_W == p_WB + RotationFromEuler(euler) * cable.attachment_B)
      throw ParameterError(fmt::format(
          "cable {} has no length at the initial pose: its attachment is at its anchor; move p_WB", i));
  }
}

PlatformState CdprPlant::InitialPlatform(const CdprPlantParams& params) {
  return {params.p_WB, QuaternionFromRotation(RotationFromEuler(params.euler)), params.v_W, params.w_W};
}

CdprPlant::Start CdprPlant::StartOf(const CdprPlantParams& params) {
  const CdprDescription& robot = params.robot;
  const int n = robot.num_cables();
  Start start{
      Eigen::VectorXd(n), Eigen::VectorXd(n), {}, {}, std::vector<int>(static_cast<std::size_t>(n), -1)};
  const Eigen::Matrix3d R_WB = RotationFromEuler(params.euler);
  for (int i = 0; i < n; ++i) {
    const CableDescription& cable = robot.cables[i];
    const Vec<3> span = cable.anchor_W - params.p_WB - R_WB * cable.attachment_B;
    try {
      start.rest_length[i] = CalcRestLength(robot, i, span, params.initial_tension[i], params.gravity, R_WB);
      const CableStatics statics =
          CalcCableStatics(robot, i, span, start.rest_length[i], params.gravity, R_WB);
      start.length_offset[i] =
          statics.length - (params.homed_length.size() > 0 ? params.homed_length[i] : span.norm());
      if (robot.winch.drum) {
        const DrumTurn turn = DrumTurnAt(*robot.winch.drum, i, start.rest_length[i]);
        start.drum_angle.push_back(turn.angle);
        start.drum_radius.push_back(turn.radius);
      }
    } catch (const RunError& error) {
      throw ParameterError(fmt::format("at the start {}", error.what()));
    }
  }
  if (robot.winch.differential) {
    for (const auto& [i, j] : robot.winch.differential->pairs) {
      start.partner[i] = j;
      start.partner[j] = i;
    }
  }
  return start;
}

CdprPlant::CableForces CdprPlant::NoForces(int num_cables) {
  return {.signals = CableSignals::Zero(num_cables),
          .statics = std::vector<CableStatics>(static_cast<std::size_t>(num_cables)),
          .reeling = CableVector::Ones(num_cables)};
}

void CdprPlant::CalcCableForces(double time, const PlatformState& x, const Eigen::VectorXd& rest_length,
                                const Eigen::VectorXd& motor_tension, const Eigen::VectorXd& reel_speed,
                                const CableFaults& faults, CableForces* out) const {
  const int n = params.robot.num_cables();
  for (const CableVector* each : {&faults.stuck, &faults.broken}) {
    if (each->size() != 0 && each->size() != n)
      throw RunError(
          fmt::format("the faults have {} entries but the robot has {} cables; give one entry each, or none",
                      each->size(), n));
  }
  CableSignals& signals = out->signals;
  out->wrench = {};
  out->energy = out->potential = 0;

  const WinchProperties& winch = params.robot.winch;
  const Eigen::Matrix3d R_WB = x.R_WB();
  for (int i = 0; i < n; ++i) {
    const CableDescription& cable = params.robot.cables[i];
    Vec<3> arm = R_WB * cable.attachment_B;
    Vec<3> span = cable.anchor_W - x.p_WB - arm;
    PathPoint moved;
    if (anchors.any()) {
      moved = anchors.At(i, time);
      span += moved.position;
    }
    const double rest = rest_length[i];
    CableStatics& statics = out->statics[i];
    statics = CalcCableStatics(params.robot, i, span, rest, params.gravity, R_WB);
    arm += statics.lead_W;
    const Vec<3>& direction = statics.direction_W;
    double length_rate = -direction.dot(x.v_W + x.w_W.cross(arm));
    if (anchors.any()) {
      length_rate += direction.dot(moved.velocity);
      statics.anchor_W += moved.position;
      statics.exit_W += moved.position;
      statics.potential_energy +=
          params.robot.cable.mass_per_length * params.gravity * rest * moved.position[2];
    }
    signals.length[i] = statics.length - start.length_offset[i];
    signals.rest_length[i] = rest - start.length_offset[i];
    signals.length_rate[i] = length_rate;
    DrumTurn turn;
    if (winch.drum) {
      turn = DrumTurnAt(*winch.drum, i, rest);
      out->reeling[i] = turn.radius / start.drum_radius[i];
    }

    const WinchMotion motion = MotionOf(i, motor_tension[i], reel_speed[i], out->reeling[i], faults);
    const double damping = params.robot.cable.axial_damping / statics.elastic_length;
    const bool pulls = statics.tension > 0 && !faults.is_broken(i);
    const double tension =
        pulls ? TensionAtWinch(winch, motion, statics.tension + damping * length_rate, damping) : 0;
    const double pull = std::max(0.0, tension - statics.tension_loss);
    signals.tension[i] = tension;
    if (pulls) {
      out->wrench.force_W += pull * direction;
      out->wrench.torque_W += arm.cross(pull * direction);
      out->energy += statics.elastic_energy;
      out->potential += statics.potential_energy;
    }
    if (winch.drum) {
      const double turned = start.drum_radius[i] * (start.drum_angle[i] - turn.angle);
      const double told = turned - (rest - start.rest_length[i]);
      signals.length[i] += told;
      signals.rest_length[i] += told;
      signals.length_rate[i] += (1 / motion.reeling - 1) * PayOutRate(winch, motion, tension);
    }
  }
  if (params.robot.springs.empty()) return;
  const Eigen::Matrix<double, 6, 1> springs = CalcSpringWrench(params.robot.springs, x.p_WB, R_WB);
  out->wrench = Sum(out->wrench, {springs.head<3>(), springs.tail<3>()});
  out->energy += CalcSpringEnergy(params.robot.springs, x.p_WB, R_WB);
}

void CdprPlant::CalcBody(const PlatformState& x, const CableForces& cables, const Payload& payload,
                         const PlatformWrench& wrench, FreeRigidBody* out) const {
  if (payload.mass < 0)
    throw RunError(fmt::format("the payload's mass is {} kg; give 0 for none, or more", payload.mass));
  if (params.extend) return;
  if (!params.robot.on_table) return out->Calc(x, Sum(cables.wrench, wrench), payload, params.gravity);
  PlatformWrench level = Sum(cables.wrench, wrench);
  level.force_W[2] = level.torque_W[0] = level.torque_W[1] = 0;
  out->Calc(x, level, {payload.mass, {payload.p_B[0], payload.p_B[1], 0}}, 0);
}

void CdprPlant::CalcRates(const PlatformState& x, const CableForces& cables, const Payload& payload,
                          const PlatformWrench& wrench, const FreeRigidBody& body,
                          const ExtendedRobot& extended, const Eigen::VectorXd& added_forces,
                          PlatformRates* out) const {
  out->quaternion = QuaternionRate(x.q_WB, x.w_W);
  if (!extended.exists()) {
    out->platform = body.acceleration();
    return;
  }
  const PlatformWrench total = Sum(cables.wrench, wrench);
  const Vec<3> r = x.R_WB() * payload.p_B;
  const Vec<3> load = -payload.mass * (x.w_W.cross(x.w_W.cross(r)) + Vec<3>(0, 0, params.gravity));
  const PointForce forces[] = {{0, x.p_WB, total.force_W, total.torque_W}, {0, x.p_WB + r, load}};
  Eigen::VectorXd acceleration;
  const auto carried = SpatialInertia(payload.mass, r, PointInertia(payload.mass, r));
  extended.CalcRates({}, forces, added_forces, carried, &acceleration, out);
  out->platform = {acceleration.tail<3>(), acceleration.head<3>()};
}

PlatformState CdprPlant::CalcPlatform(const PlatformState& x) const {
  PlatformState platform = x;
  platform.q_WB.normalize();
  return platform;
}

Vec<3> CdprPlant::CalcEuler(const PlatformState& x) const {
  return EulerFromRotation(x.R_WB());
}

CdprEnergy CdprPlant::CalcEnergy(const PlatformState& x, const CableForces& cables, const FreeRigidBody& body,
                                 const Payload& payload, const ExtendedRobot& extended) const {
  const double payload_height = x.p_WB[2] + (x.R_WB() * payload.p_B)[2];
  if (extended.exists()) {
    const Vec<3> velocity = x.v_W + x.w_W.cross(x.R_WB() * payload.p_B);
    return {.kinetic = extended.KineticEnergy() + payload.mass / 2 * velocity.squaredNorm(),
            .potential = extended.PotentialEnergy() + params.gravity * payload.mass * payload_height +
                         cables.potential,
            .elastic = cables.energy};
  }
  return {.kinetic = body.kinetic_energy(),
          .potential = params.gravity * (params.robot.mass * x.p_WB[2] + payload.mass * payload_height) +
                       cables.potential,
          .elastic = cables.energy};
}

Geometry CdprPlant::MakeGeometry() const {
  Geometry shapes = MakeCdprGeometry(params.robot);
  shapes.insert(shapes.end(), additions.shapes.begin(), additions.shapes.end());
  return shapes;
}

void CdprPlant::CalcGeometry(const PlatformState& x, const CableForces& cables, const Payload& payload,
                             const PlatformWrench& wrench, const ExtendedRobot& extended,
                             Geometry* out) const {
  MoveCdprGeometry(params.robot, x, cables.signals.tension, cables.statics, payload, wrench, out);
  if (extended.exists()) extended.MoveShapes(out->size() - additions.shapes.size(), out);
}

PlatformWrench CdprPlant::CalcAddedWrench(const PlatformState& x, const CableForces& cables,
                                          const Payload& payload, const PlatformWrench& wrench,
                                          const ExtendedRobot& extended, const PlatformRates& rates) const {
  if (!extended.exists()) return {};
  const auto& [a, alpha] = rates.platform;
  Eigen::VectorXd acceleration(6);
  acceleration << alpha, a;
  const Vec<3> g(0, 0, -params.gravity), r = x.R_WB() * payload.p_B;
  const Vec<3> load = payload.mass * (a + alpha.cross(r) + x.w_W.cross(x.w_W.cross(r)) - g);
  const PlatformWrench rate = extended.MomentumRate(acceleration, x.p_WB),
                       others = Sum(cables.wrench, wrench);
  return {rate.force_W - params.robot.mass * g + load - others.force_W,
          rate.torque_W + r.cross(load) - others.torque_W};
}

PlatformState CdprPlant::CalcPlatformRate(const PlatformState& x, const PlatformRates& rates) const {
  return {x.v_W, rates.quaternion + kNormRate * (1 - x.q_WB.squaredNorm()) * x.q_WB, rates.platform.a_W,
          rates.platform.alpha_W};
}

void CdprPlant::CalcRestLengthRate(const CableForces& cables, const Eigen::VectorXd& motor_tension,
                                   const Eigen::VectorXd& reel_speed, const CableFaults& faults,
                                   Eigen::VectorXd* rate) const {
  const int n = params.robot.num_cables();
  rate->resize(n);
  for (int i = 0; i < n; ++i)
    (*rate)[i] = PayOutRate(params.robot.winch,
                            MotionOf(i, motor_tension[i], reel_speed[i], cables.reeling[i], faults),
                            cables.signals.tension[i]);
}

void CdprPlant::CalcMotorTensionRate(const Eigen::VectorXd& motor_tension, const CableVector& command,
                                     Eigen::VectorXd* rate) const {
  const int n = params.robot.num_cables();
  if (command.size() != n)
    throw RunError(fmt::format(
        "the command has {} entries but the robot has {} cables; give one tension each", command.size(), n));
  const auto asked_of = [&](int i) { return command[i] < 0 ? 0 : command[i]; };  // keeps NaN
  rate->resize(n);
  for (int i = 0; i < n; ++i) {
    double asked = asked_of(i);
    if (const int j = start.partner[i]; j >= 0)
      asked = GivenByDifferential(*params.robot.winch.differential, asked, asked_of(j));
    (*rate)[i] = (asked - motor_tension[i]) / params.robot.winch.time_constant;
  }
}

void CdprPlant::CalcReelAcceleration(const CableForces& cables, const Eigen::VectorXd& motor_tension,
                                     const Eigen::VectorXd& reel_speed, const CableFaults& faults,
                                     Eigen::VectorXd* acceleration) const {
  const WinchProperties& winch = params.robot.winch;
  if (params.lock_winches || winch.mode == WinchMode::kTension) {
    acceleration->setZero(params.robot.num_cables());
  } else {
    *acceleration = (cables.reeling.cwiseProduct(cables.signals.tension) - motor_tension -
                     winch.reel_damping * reel_speed) /
                    winch.effective_mass;
    for (Eigen::Index i = 0; i < acceleration->size(); ++i)
      if (faults.is_stuck(i)) (*acceleration)[i] = -reel_speed[i] / winch.time_constant;
  }
}

}  // namespace tenon
