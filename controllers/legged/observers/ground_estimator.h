#pragma once

#include <tenon/plants/model/quadruped_description.h>
#include <tenon/plants/signals/gait_signals.h>
#include <tenon/plants/signals/ground_plane.h>
#include <tenon/plants/signals/legged_signals.h>
#include <tenon/systems/block.h>

namespace tenon {

/// Noise model of GroundEstimator: standard deviations.
struct GroundBelief {
  double roughness = 0.03;         ///< height of a foothold above the plane, 3 cm for blocks [m]
  double level_walk = 0.02;        ///< change of the plane's height from foothold to foothold [m]
  double slope_walk = 0.003;       ///< change of its slope from foothold to foothold, along each axis
  double start_slope = 1;          ///< slope at the start of the walk
  double start_roughness = 0.005;  ///< roughness of the first footholds [m]
  double doubt = 3;                ///< dead band of the output slope, in standard deviations of the slope

  static FieldList Fields() {
    const auto lengths = [](double ratio, const Scale& scale) { return ratio * scale.length; };
    return {Field("roughness_m", &GroundBelief::roughness)
                .Positive()
                .Because("four feet never lie exactly in a plane")
                .Scaled("roughness_l", lengths),
            Field("level_walk_m", &GroundBelief::level_walk)
                .AtLeast(0)
                .Because("0 turns it off")
                .Scaled("level_walk_l", lengths),
            Field("slope_walk", &GroundBelief::slope_walk).AtLeast(0).Because("0 turns it off"),
            Field("start_slope", &GroundBelief::start_slope).AtLeast(0).Because("0 turns it off"),
            Field("start_roughness_m", &GroundBelief::start_roughness)
                .Positive()
                .Because("four feet never lie exactly in a plane")
                .Scaled("start_roughness_l", lengths),
            Field("doubt", &GroundBelief::doubt).AtLeast(0).Because("0 turns it off")};
  }
};

struct GroundEstimatorParams {
  QuadrupedDescription robot;
  GroundBelief belief;
  Rate rate = Hz(1000);
  void Validate() const { robot.CheckMass(); }  ///< throws ParameterError
};

/// Estimates the slope of the ground from the footholds by a Kalman filter on the height and the slope of a
/// plane. The measurements are the lowest points, along the plane's normal, of feet at touchdown,
///
///     z_i = h + s . (p_i - p) + roughness,    h and s wander from one foothold to the next,
///
/// so that the heights of single blocks average out and a ramp does not. The slope of the output is
/// (1 - (doubt sigma / |s|)^2)+ s, with the filter's standard deviation sigma of s (a James-Stein shrinkage):
/// a slope that is estimated wrongly on blocks would make touchdowns late or early at every step. The output
/// plane has this slope and passes through the centroid of the stance feet; it stays constant while no foot
/// stands. If the first footholds tell a slope, they are measured once more without h and s wandering, since
/// they stand at the same time, and with the contact points on that slope.
class GroundEstimator final : public LeafSystem<GroundEstimatorParams> {
 public:
  using LeafSystem::LeafSystem;

  /// Memory of the estimator.
  struct Memory {
    bool started = false;
    std::array<bool, kNumLegs> stood{};  ///< stance feet of the last tick
    GroundPlane plane;                   ///< estimate of the filter; p_W is the last foothold
    Vec<6> covariance = Vec<6>::Zero();  ///< covariance of (height, slope): hh, hx, hy, xx, xy, yy
    GroundPlane told;                    ///< output of the last tick

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
  Parameter<GroundBelief> belief{this, {"belief"}, params.belief, "noise model of the ground"};
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
