#include <tenon/plants/cdpr/cdpr_plant.h>

#include <fmt/format.h>
#include <tenon/plants/model/euler.h>
#include <tenon/systems/framework/errors.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace tenon {
namespace {

constexpr double kNormRate = 5;  // [1/s], with which the quaternion's length returns to 1

void CheckFinite(const char* name, const Vec<3>& v) {
  if (!v.allFinite())
    throw ParameterError(
        fmt::format("{} is ({}, {}, {}); give three finite numbers", name, v[0], v[1], v[2]));
}

/// The tension of a taut cable in tension or torque mode, see the header.
double TautTension(const CdprPlantParams& params, double rest, double motor_tension, double reel_speed,
                   double length, double length_rate, bool stuck) {
  const WinchProperties& winch = params.robot.winch;
  const double damping = params.robot.cable.axial_damping / rest;
  const double strained = params.robot.cable.axial_stiffness / rest * (length - rest) + damping * length_rate;
  if (params.lock_winches || stuck) return std::max(0.0, strained);
  if (winch.mode == WinchMode::kTorque) return std::max(0.0, strained - damping * reel_speed);
  return std::max(0.0,
                  (winch.reel_damping * strained + damping * motor_tension) / (winch.reel_damping + damping));
}

}  // namespace

void CdprPlantParams::Validate() const {
  robot.Validate();
  CheckFinite("p_WB", p_WB);
  CheckFinite("euler", euler);
  CheckFinite("v_W", v_W);
  CheckFinite("w_W", w_W);
  if (!std::isfinite(gravity)) throw ParameterError(fmt::format("gravity is {}; give m/s^2", gravity));
  if (initial_tension.size() != robot.num_cables())
    throw ParameterError(
        fmt::format("initial_tension has {} entries but the robot '{}' has {} cables; give one tension each",
                    initial_tension.size(), robot.name, robot.num_cables()));
  for (int i = 0; i < robot.num_cables(); ++i) {
    if (!(std::isfinite(initial_tension[i]) && initial_tension[i] >= 0))
      throw ParameterError(fmt::format(
          "initial_tension of cable {} is {} N; a cable cannot push, give 0 or more", i, initial_tension[i]));
    const CableDescription& cable = robot.cables[static_cast<std::size_t>(i)];
    if (cable.anchor_W == p_WB + RotationFromEuler(euler) * cable.attachment_B)
      throw ParameterError(fmt::format(
          "cable {} has no length at the initial pose: its attachment is at its anchor; move p_WB", i));
  }
}

PlatformState CdprPlant::InitialPlatform(const CdprPlantParams& params) {
  return {params.p_WB, QuaternionFromRotation(RotationFromEuler(params.euler)), params.v_W, params.w_W};
}

Eigen::VectorXd CdprPlant::InitialRestLength(const CdprPlantParams& params) {
  Eigen::VectorXd rest_length(params.robot.num_cables());
  const Eigen::Matrix3d R_WB = RotationFromEuler(params.euler);
  for (int i = 0; i < params.robot.num_cables(); ++i) {
    const CableDescription& cable = params.robot.cables[static_cast<std::size_t>(i)];
    const double length = (cable.anchor_W - params.p_WB - R_WB * cable.attachment_B).norm();
    rest_length[i] = length / (1 + params.initial_tension[i] / params.robot.cable.axial_stiffness);
  }
  return rest_length;
}

void CdprPlant::CalcCableForces(const PlatformState& x, const Eigen::VectorXd& rest_length,
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
  signals.rest_length = rest_length;
  out->wrench = {};
  out->energy = 0;

  const Eigen::Matrix3d R_WB = x.R_WB();
  for (int i = 0; i < n; ++i) {
    const CableDescription& cable = params.robot.cables[static_cast<std::size_t>(i)];
    const Vec<3> arm = R_WB * cable.attachment_B;
    const Vec<3> span = cable.anchor_W - x.p_WB - arm;
    const double length = span.norm();
    const double rest = rest_length[i];
    if (length == 0)
      throw RunError(
          fmt::format("cable {} has no length and so no direction: its attachment is at its anchor", i));
    if (rest <= 0)
      throw RunError(
          fmt::format("cable {} is reeled in completely (rest length {} m); command less tension or move the "
                      "platform away "
                      "from the anchor",
                      i, rest));
    const Vec<3> direction = span / length;
    const double length_rate = -direction.dot(x.v_W + x.w_W.cross(arm));
    const bool taut = length > rest && !faults.is_broken(i);
    const double tension = taut ? TautTension(params, rest, motor_tension[i], reel_speed[i], length,
                                              length_rate, faults.is_stuck(i))
                                : 0;

    signals.length[i] = length;
    signals.length_rate[i] = length_rate;
    signals.tension[i] = tension;
    out->wrench.force_W += tension * direction;
    out->wrench.torque_W += arm.cross(tension * direction);
    if (taut)
      out->energy += params.robot.cable.axial_stiffness / (2 * rest) * (length - rest) * (length - rest);
  }
}

void CdprPlant::CalcBody(const PlatformState& x, const CableForces& cables, const Payload& payload,
                         const PlatformWrench& wrench, FreeRigidBody* out) const {
  if (payload.mass < 0)
    throw RunError(fmt::format("the payload's mass is {} kg; give 0 for none, or more", payload.mass));
  const PlatformWrench total{cables.wrench.force_W + wrench.force_W,
                             cables.wrench.torque_W + wrench.torque_W};
  out->Calc(x, total, payload, params.gravity);
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
                                 const Payload& payload) const {
  const double payload_height = x.p_WB[2] + (x.R_WB() * payload.p_B)[2];
  return {.kinetic = body.kinetic_energy(),
          .potential = params.gravity * (params.robot.mass * x.p_WB[2] + payload.mass * payload_height),
          .elastic = cables.energy};
}

void CdprPlant::CalcGeometry(const PlatformState& x, const CableForces& cables, const Payload& payload,
                             const PlatformWrench& wrench, Geometry* out) const {
  MoveCdprGeometry(params.robot, x, cables.signals.tension, payload, wrench, out);
}

PlatformState CdprPlant::CalcPlatformRate(const PlatformState& x, const FreeRigidBody& body) const {
  return {x.v_W, body.quaternion_rate() + kNormRate * (1 - x.q_WB.squaredNorm()) * x.q_WB,
          body.acceleration().a_W, body.acceleration().alpha_W};
}

void CdprPlant::CalcRestLengthRate(const CableForces& cables, const Eigen::VectorXd& motor_tension,
                                   const Eigen::VectorXd& reel_speed, const CableFaults& faults,
                                   Eigen::VectorXd* rate) const {
  const WinchProperties& winch = params.robot.winch;
  if (params.lock_winches) {
    rate->setZero(params.robot.num_cables());
  } else if (winch.mode == WinchMode::kTension) {
    *rate = (cables.signals.tension - motor_tension) / winch.reel_damping;
  } else {
    *rate = reel_speed;
  }
  for (Eigen::Index i = 0; i < rate->size(); ++i)
    if (faults.is_stuck(i)) (*rate)[i] = 0;
}

void CdprPlant::CalcMotorTensionRate(const Eigen::VectorXd& motor_tension, const CableVector& command,
                                     Eigen::VectorXd* rate) const {
  const int n = params.robot.num_cables();
  if (command.size() != n)
    throw RunError(fmt::format(
        "the command has {} entries but the robot has {} cables; give one tension each", command.size(), n));
  rate->resize(n);
  for (int i = 0; i < n; ++i) {
    const double asked = command[i] < 0 ? 0 : command[i];  // written so that nan stays nan
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
    *acceleration =
        (cables.signals.tension - motor_tension - winch.reel_damping * reel_speed) / winch.effective_mass;
    for (Eigen::Index i = 0; i < acceleration->size(); ++i)
      if (faults.is_stuck(i)) (*acceleration)[i] = -reel_speed[i] / winch.time_constant;
  }
}

}  // namespace tenon
