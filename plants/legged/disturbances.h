#pragma once

#include <tenon/plants/model/quadruped_description.h>
#include <tenon/plants/signals/legged_signals.h>
#include <tenon/systems/framework/block/parameter.h>
#include <tenon/systems/framework/block/ports.h>
#include <tenon/systems/framework/block/state.h>
#include <tenon/systems/framework/block/system.h>

#include <limits>

namespace tenon {

/// @file
/// Forces of the surroundings on a quadruped. Each of these blocks puts out one force; a ForceBundle makes
/// the ExternalForces of them that QuadrupedPlant takes.

/// A point on a leg, without a force: `height` runs along the leg from 0 at the foot over 0.5 at the knee to
/// 1 at the hip's pitch joint. Throws ParameterError for a leg or a height that is not there.
ExternalForce PointOnLeg(const QuadrupedDescription& robot, int leg, double height);

struct SineForceParams {
  ExternalForce amplitude = {};                          ///< where, and how much [N], [N m]
  double angular_frequency = 1;                          ///< w [rad/s]
  double start = 0;                                      ///< [s]
  double end = std::numeric_limits<double>::infinity();  ///< [s]

  void Validate() const;  ///< throws ParameterError
};

/// f(t) = amplitude sin(w (t - start)) for start <= t < end, else none.
///
///     port out    force
///     parameters  amplitude, angular_frequency [rad/s], start, end [s]
class SineForce final : public LeafSystem<SineForceParams> {
 public:
  using LeafSystem::LeafSystem;
  Parameter<ExternalForce> amplitude{this, {"amplitude"}, params.amplitude, "where, and how much"};
  Parameter<double> angular_frequency{
      this, {"angular_frequency", "rad/s"}, params.angular_frequency, "of the sine"};
  Parameter<double> start{this, {"start", "s"}, params.start, "when it begins"};
  Parameter<double> end{this, {"end", "s"}, params.end, "when it ends"};
  OutputPort<ExternalForce> force{
      this, {"force"}, Uses(time, amplitude, angular_frequency, start, end), &SineForce::CalcForce};
  NextJump next_jump{this, "next_jump", Uses(time, start, end), [](double time, double start, double end) {
                       return time < start ? start : time < end ? end : kNever;
                     }};

 private:
  ExternalForce CalcForce(double time, const ExternalForce& amplitude, double angular_frequency, double start,
                          double end) const;
};

struct PulseForceParams {
  ExternalForce push = {};  ///< where, and how much [N], [N m]
  double start = 0;         ///< [s]
  double duration = 0;      ///< [s]; infinity for a force that stays
  Rate rate = Hz(1000);     ///< the instants are rounded up to its ticks, which end integration steps

  void Validate() const;  ///< throws ParameterError
};

/// A constant force or torque on any body for part of the run: a push, or a wrench on the trunk.
///
///     port out    force  sampled
///     parameters  push, start, duration [s]
class PulseForce final : public LeafSystem<PulseForceParams> {
 public:
  using LeafSystem::LeafSystem;
  Parameter<ExternalForce> push{this, {"push"}, params.push, "where, and how much"};
  Parameter<double> start{this, {"start", "s"}, params.start, "when it begins"};
  Parameter<double> duration{this, {"duration", "s"}, params.duration, "infinity for a force that stays"};
  OutputPort<ExternalForce> force{
      this, {"force"}, Sampled{params.rate}, Uses(time, push, start, duration), &PulseForce::CalcForce};

 private:
  ExternalForce CalcForce(double time, const ExternalForce& push, double start, double duration) const;
};

struct RandomForceParams {
  QuadrupedDescription robot = {};
  bool on_trunk = false;  ///< at B's origin instead of a leg
  double lower = 0;       ///< magnitude, at least [N]
  double upper = 0;       ///< at most [N]
  Rate period = Hz(0.5);

  void Validate() const;  ///< throws ParameterError
};

/// A force that changes every period, and stays in between: on a random leg at a random height (or on the
/// trunk), of random magnitude and direction, all uniformly distributed.
///
///     port out    force  sampled
///     parameters  on_trunk, lower, upper [N]
class RandomForce final : public LeafSystem<RandomForceParams> {
 public:
  using LeafSystem::LeafSystem;
  Parameter<bool> on_trunk{this, {"on_trunk"}, params.on_trunk, "at B's origin instead of a leg"};
  Parameter<double> lower{this, {"lower", "N"}, params.lower, "magnitude, at least"};
  Parameter<double> upper{this, {"upper", "N"}, params.upper, "magnitude, at most"};
  Random random{this, "random"};
  OutputPort<ExternalForce> force{
      this, {"force"}, Sampled{params.period}, Uses(on_trunk, lower, upper, random), &RandomForce::CalcForce};

 private:
  ExternalForce CalcForce(bool on_trunk, double lower, double upper, RandomStream& random) const;
};

struct ForceBundleParams {
  std::size_t count = 0;  ///< of inputs, up to kMaxExternalForces

  void Validate() const;  ///< throws ParameterError
};

/// Several forces as one signal.
///
///     ports in  force_0, force_1, ...
///     port out  forces
class ForceBundle final : public LeafSystem<ForceBundleParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPorts<ExternalForce> force{this, {"force"}, params.count};
  OutputPort<ExternalForces> forces{this, {"forces"}, Uses(force), &ForceBundle::CalcForces};

 private:
  ExternalForces CalcForces(const Inputs<ExternalForce>& force) const;
};

}  // namespace tenon
