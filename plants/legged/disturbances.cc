#include <tenon/plants/legged/disturbances.h>

#include <fmt/core.h>

#include <numbers>

namespace tenon {
namespace {

void CheckForce(const ExternalForce& force) {
  Demand(
      force.body >= 0 && force.body <= kNumJoints,
      fmt::format("body {} does not exist; give 0 for the trunk or 1 to {} for the body that a joint moves",
                  force.body, kNumJoints));
  Demand(internal::IsFinite(force), "point, force and torque must be finite: give m, N and N m");
}

}  // namespace

ExternalForce PointOnLeg(const QuadrupedDescription& robot, int leg, double height) {
  Demand(leg >= 0 && leg < kNumLegs, fmt::format("leg {} does not exist; give 0 to {}", leg, kNumLegs - 1));
  Demand(height >= 0 && height <= 1,
         fmt::format("height {} is not on the leg; give 0 for the foot to 1 for the hip", height));
  const LegDescription& at = robot.legs[static_cast<std::size_t>(leg)];
  const int shank = kJointsPerLeg * (leg + 1);
  ExternalForce force;
  if (height <= 0.5) {
    force.body = shank;
    force.p_B = (1 - 2 * height) * at.foot_J;
  } else {
    force.body = shank - 1;
    force.p_B = (2 - 2 * height) * at.joints[2].p_PJ;
  }
  return force;
}

void SineForceParams::Validate() const {
  CheckForce(amplitude);
  Demand(end >= start,
         fmt::format("the force ends at {} s, before its start at {} s: exchange them", end, start));
}

ExternalForce SineForce::CalcForce(double time, const ExternalForce& amplitude, double angular_frequency,
                                   double start, double end) const {
  ExternalForce force = amplitude;
  const bool on = time >= start && time < end;
  const double wave = on ? std::sin(angular_frequency * (time - start)) : 0;
  force.force_W *= wave;
  force.torque_W *= wave;
  return force;
}

void PulseForceParams::Validate() const {
  CheckForce(push);
}

ExternalForce PulseForce::CalcForce(double time, const ExternalForce& push, double start,
                                    double duration) const {
  // Tolerates the rounding of start + duration; ticks are exact multiples of the period.
  const double rounding = 1e-6 * params.rate.period();
  const double since = time - start + rounding;
  return since >= 0 && since < duration ? push : ExternalForce{};
}

void RandomForceParams::Validate() const {
  Demand(robot.mass() > 0, "the robot has no mass; give a robot, as LoadQuadruped reads it");
  Demand(upper >= lower,
         fmt::format("the bounds of the magnitude are {} and {} N: give lower <= upper", lower, upper));
}

ExternalForce RandomForce::CalcForce(bool on_trunk, double lower, double upper, RandomStream& random) const {
  // Draws equally many numbers for the trunk and for a leg, so that on_trunk does not change the sequence.
  const int leg = static_cast<int>(random.Uniform(0, kNumLegs));
  const double height = random.Uniform();
  const double magnitude = random.Uniform(lower, upper);
  const double z = random.Uniform(-1, 1), angle = random.Uniform(0, 2 * std::numbers::pi);
  ExternalForce force;
  if (!on_trunk) force = PointOnLeg(params.robot, leg, height);
  const double r = std::sqrt(1 - z * z);
  force.force_W = magnitude * Vec<3>(r * std::cos(angle), r * std::sin(angle), z);
  return force;
}

void ForceBundleParams::Validate() const {
  Demand(count <= kMaxExternalForces,
         fmt::format("{} forces are too many: a robot takes at most {}", count, kMaxExternalForces));
}

ExternalForces ForceBundle::CalcForces(const Inputs<ExternalForce>& force) const {
  ExternalForces forces;
  for (std::size_t i = 0; i < force.size(); ++i) forces[i] = force[i];
  return forces;
}

}  // namespace tenon
