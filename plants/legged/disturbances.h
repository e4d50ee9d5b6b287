#pragma once

#include <tenon/plants/model/quadruped_description.h>
#include <tenon/plants/signals/legged_signals.h>
#include <tenon/systems/block.h>

namespace tenon {

/// @file
/// External forces on a quadruped. Each block outputs one force; a ForceBundle combines them into the
/// ExternalForces that QuadrupedPlant reads.

/// An ExternalForce of zero at a point of a leg. `height` is 0 at the foot, 0.5 at the knee and 1 at the hip
/// pitch joint. Throws ParameterError if `leg` or `height` is out of range.
ExternalForce PointOnLeg(const QuadrupedDescription& robot, int leg, double height);

struct SineForceParams {
  ExternalForce amplitude = {};                          ///< point of application and amplitude [N], [N m]
  double angular_frequency = 1;                          ///< w [rad/s]
  double start = 0;                                      ///< [s]
  double end = std::numeric_limits<double>::infinity();  ///< [s]

  void Validate() const;  ///< throws ParameterError
};

/// A sinusoidal force: f(t) = amplitude sin(w (t - start)) for start <= t < end, else 0.
class SineForce final : public LeafSystem<SineForceParams> {
 public:
  using LeafSystem::LeafSystem;
  Parameter<ExternalForce> amplitude{
      this, {"amplitude"}, params.amplitude, "point of application and amplitude"};
  Parameter<double> angular_frequency{this,
                                      {"angular_frequency", "rad/s"},
                                      params.angular_frequency,
                                      "angular frequency of the sine",
                                      Range().Finite()};
  Parameter<double> start{this, {"start", "s"}, params.start, "start of the force", Range().Finite()};
  Parameter<double> end{this, {"end", "s"}, params.end, "end of the force", Range().Finite().OrInfinite()};
  OutputPort<ExternalForce> force{
      this, {"force"}, Uses(time, amplitude, angular_frequency, start, end), &SineForce::CalcForce};
  NextJump next_jump{this, "next_jump", Uses(time, start, end), [](double t, double from, double to) {
                       return t < from ? from : t < to ? to : kNever;
                     }};

 private:
  ExternalForce CalcForce(double time, const ExternalForce& amplitude, double angular_frequency, double start,
                          double end) const;
};

struct PulseForceParams {
  ExternalForce push = {};  ///< point of application and force [N], [N m]
  double start = 0;         ///< [s]
  double duration = 0;      ///< infinity for a permanent force [s]
  Rate rate = Hz(1000);     ///< start and end are rounded up to ticks, where integration steps end

  void Validate() const;  ///< throws ParameterError
};

/// A constant force and torque on a body for a part of the run.
class PulseForce final : public LeafSystem<PulseForceParams> {
 public:
  using LeafSystem::LeafSystem;
  Parameter<ExternalForce> push{this, {"push"}, params.push, "point of application and force"};
  Parameter<double> start{this, {"start", "s"}, params.start, "start of the force", Range().Finite()};
  Parameter<double> duration{this,
                             {"duration", "s"},
                             params.duration,
                             "duration of the force; infinity: permanent",
                             Range().AtLeast(0).OrInfinite()};
  OutputPort<ExternalForce> force{
      this, {"force"}, Sampled{params.rate}, Uses(time, push, start, duration), &PulseForce::CalcForce};

 private:
  ExternalForce CalcForce(double time, const ExternalForce& push, double start, double duration) const;
};

struct RandomForceParams {
  QuadrupedDescription robot = {};
  bool on_trunk = false;  ///< acts at B's origin instead of a leg
  double lower = 0;       ///< lower bound of the magnitude [N]
  double upper = 0;       ///< upper bound of the magnitude [N]
  Rate period = Hz(0.5);

  void Validate() const;  ///< throws ParameterError
};

/// A random force that is constant within each period: on a random leg at a random height (or on the trunk),
/// with random magnitude and direction, all uniformly distributed.
class RandomForce final : public LeafSystem<RandomForceParams> {
 public:
  using LeafSystem::LeafSystem;
  Parameter<bool> on_trunk{
      this, {"on_trunk"}, params.on_trunk, "whether the force acts at B's origin instead of on a leg"};
  Parameter<double> lower{
      this, {"lower", "N"}, params.lower, "lower bound of the magnitude", Range().AtLeast(0)};
  Parameter<double> upper{
      this, {"upper", "N"}, params.upper, "upper bound of the magnitude", Range().AtLeast(0)};
  Random random{this, "random"};
  OutputPort<ExternalForce> force{
      this, {"force"}, Sampled{params.period}, Uses(on_trunk, lower, upper, random), &RandomForce::CalcForce};

 private:
  ExternalForce CalcForce(bool on_trunk, double lower, double upper, RandomStream& random) const;
};

struct ForceBundleParams {
  std::size_t count = 0;  ///< number of inputs, up to kMaxExternalForces

  void Validate() const;  ///< throws ParameterError
};

/// Combines several forces into one signal.
class ForceBundle final : public LeafSystem<ForceBundleParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPorts<ExternalForce> force{this, {"force"}, params.count};
  OutputPort<ExternalForces> forces{this, {"forces"}, Uses(force), &ForceBundle::CalcForces};

 private:
  ExternalForces CalcForces(const Inputs<ExternalForce>& force) const;
};

}  // namespace tenon
