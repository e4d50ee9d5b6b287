#pragma once

#include <tenon/plants/model/quadruped_description.h>
#include <tenon/plants/signals/gait_signals.h>
#include <tenon/plants/signals/ground_plane.h>
#include <tenon/plants/signals/legged_signals.h>
#include <tenon/systems/framework/block/parameter.h>
#include <tenon/systems/framework/block/ports.h>
#include <tenon/systems/framework/block/state.h>
#include <tenon/systems/framework/block/system.h>

#include <array>

namespace tenon {

/// What an estimator believes of the ground, as standard deviations.
struct GroundBelief {
  double roughness = 0.03;         ///< of single footholds from the plane: of blocks of 3 cm, say [m]
  double level_walk = 0.02;        ///< by how much the plane's height changes from foothold to foothold [m]
  double slope_walk = 0.003;       ///< and its slope, along each axis
  double start_slope = 1;          ///< of the slope where the walk begins,
  double start_roughness = 0.005;  ///< and of the ground there, on which the robot was put down [m]
  double doubt = 3;                ///< a slope of fewer of its own deviations is told as level

  static FieldList Fields() {
    return {{"roughness_m", &GroundBelief::roughness},
            {"level_walk_m", &GroundBelief::level_walk},
            {"slope_walk", &GroundBelief::slope_walk},
            {"start_slope", &GroundBelief::start_slope},
            {"start_roughness_m", &GroundBelief::start_roughness},
            {"doubt", &GroundBelief::doubt}};
  }
  void Validate() const;  ///< throws ParameterError unless roughness is positive and the rest not negative
};

struct GroundEstimatorParams {
  QuadrupedDescription robot;
  GroundBelief belief;
  Rate rate = Hz(1000);
  void Validate() const;  ///< throws ParameterError
};

/// Feels the slope of the ground by the feet: a Kalman filter on height and slope of a plane, measured by the
/// lowest place, along its normal, of each foot that comes to stand,
///
///     z_i = h + s . (p_i - p) + roughness,    h and s wander from one foothold to the next,
///
/// so that what single blocks have in height is averaged out, and a ramp is not. The slope that is told is (1
/// - (doubt sigma / |s|)^2)+ s with the filter's deviation sigma of s, after James and Stein: on blocks,
/// footholds at a slope that is none would be late or early at every step. The plane that is told has this
/// slope and goes through the middle of the feet that stand; it stays while none does.
///
///     | port     | kind            | type            |
///     | state    | input           | LeggedState     |
///     | schedule | input           | ContactSchedule |
///     | ground   | output, sampled | GroundPlane     |
///     | belief   | parameter       | GroundBelief    |
class GroundEstimator final : public LeafSystem<GroundEstimatorParams> {
 public:
  using LeafSystem::LeafSystem;

  /// What the estimator remembers.
  struct Memory {
    bool started = false;
    std::array<bool, kNumLegs> stood{};  ///< at the last tick
    GroundPlane plane;                   ///< of the filter, p_W the last foothold's place
    Vec<6> covariance = Vec<6>::Zero();  ///< of (height, slope): hh, hx, hy, xx, xy, yy
    GroundPlane told;

    static FieldList Fields() {
      return {{"started", &Memory::started},
              {"stood", &Memory::stood, "", kLegElements},
              {"plane", &Memory::plane},
              {"covariance", &Memory::covariance},
              {"told", &Memory::told}};
    }
  };

  InputPort<LeggedState> state{this, {"state"}};
  InputPort<ContactSchedule> schedule{this, {"schedule"}};
  Parameter<GroundBelief> belief{
      this, {"belief"}, params.belief, "how rough the ground is, and how it changes"};
  Scratch<Memory> memory{this, "memory", Memory()};
  OutputPort<GroundPlane> ground{this,
                                 {"ground"},
                                 Sampled{params.rate},
                                 Uses(state, schedule, belief, memory),
                                 &GroundEstimator::CalcGround};

 private:
  GroundPlane CalcGround(const LeggedState& state, const ContactSchedule& schedule,
                         const GroundBelief& belief, Memory& memory) const;
};

}  // namespace tenon
