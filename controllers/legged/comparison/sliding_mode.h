#pragma once

#include <tenon/systems/framework/types/signal.h>

namespace tenon {

/// Sliding mode control with a boundary layer (Slotine and Li, Applied Nonlinear Control, 1991, sections 7.1
/// and 7.2) of an error e of position or attitude, along each axis with the surface s = e' + lambda e:
///
///     a = lambda e' + k sat(s / phi),   phi = lambda epsilon,   k = kappa phi.
///
/// With e'' = d - a and a disturbance |d| < k, an error outside of the layer |s| <= phi reaches it within
/// (|s(0)| - phi) / (k - |d|). Without disturbance |s| falls at the rate k until then, and inside s' = -kappa
/// s and e' = -lambda e + s: the linear feedback with the stiffness lambda kappa and the damping lambda +
/// kappa. In the layer a constant d leaves the error d / (lambda kappa), at most epsilon.
struct SlidingMode {
  double slope = 10;    ///< lambda: decay of the error on the surface [1/s]
  double reach = 10;    ///< kappa: decay of the distance from the surface in the layer [1/s]
  double layer = 0.01;  ///< epsilon: error up to which the feedback is linear [m], or [rad]

  /// The feedback acceleration a for the error and its rate.
  Eigen::Vector3d Acceleration(const Eigen::Vector3d& error, const Eigen::Vector3d& rate) const {
    const double phi = slope * layer;
    const Eigen::Vector3d s = rate + slope * error;
    return slope * rate + reach * s.cwiseMin(phi).cwiseMax(-phi);
  }
};

/// Sliding mode control of the CoM, the trunk's attitude and the swing feet in a WholeBodyController.
struct SlidingGains {
  SlidingMode com, trunk, swing;

  static FieldList Fields() {
    using G = SlidingGains;
    using M = SlidingMode;
    const auto lengths = [](double layer, const Scale& s) { return layer * s.length; };
    return {Field("com_slope_per_s", &G::com, &M::slope).Positive(),
            Field("com_reach_per_s", &G::com, &M::reach).Positive(),
            Field("com_layer_m", &G::com, &M::layer).Positive().Scaled("com_layer_l", lengths),
            Field("trunk_slope_per_s", &G::trunk, &M::slope).Positive(),
            Field("trunk_reach_per_s", &G::trunk, &M::reach).Positive(),
            Field("trunk_layer_rad", &G::trunk, &M::layer).Positive(),
            Field("swing_slope_per_s", &G::swing, &M::slope).Positive(),
            Field("swing_reach_per_s", &G::swing, &M::reach).Positive(),
            Field("swing_layer_m", &G::swing, &M::layer).Positive().Scaled("swing_layer_l", lengths)};
  }
};

}  // namespace tenon
