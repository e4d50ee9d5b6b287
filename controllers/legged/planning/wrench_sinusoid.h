#pragma once

#include <tenon/systems/framework/types/signal.h>

namespace tenon {

/// A wrench y = m + a sin(phase) with one frequency w for all components, followed recursively. With the
/// error e = y - m - x of the in-phase part x, whose quadrature q lags by a quarter of a period,
///
///     m' = k_m w e,   x' = w (k e - q),   q' = w x,   w' = -g w^2 e . q / (|x|^2 + |q|^2 + n^2):
///
/// a second-order generalized integrator with a frequency-locked loop (Rodriguez et al., "Multiresonant
/// frequency-locked loop for grid synchronization", IEEE Transactions on Industrial Electronics 58(1), 2011)
/// and an estimate of the offset (Karimi-Ghartemani et al., "Addressing DC component in PLL and notch filter
/// algorithms", IEEE Transactions on Power Electronics 27(1), 2012). The frequency
/// starts at 1 Hz, is found within four periods at 0.25 to 1 Hz and within eight at 2 Hz, and stays within
/// 0.16 and 4 Hz; amplitudes below n hardly move it.
struct WrenchSinusoid {
  double frequency = 6.283185307179586;  ///< w [rad/s]
  Vec<6> mean = Vec<6>::Zero();          ///< m [m g, m g h]
  Vec<6> in_phase = Vec<6>::Zero();      ///< x [m g, m g h]
  Vec<6> quadrature = Vec<6>::Zero();    ///< q [m g, m g h]

  void Update(const Vec<6>& wrench /* [m g, m g h] */, double dt /* [s] */);
  /// The wrench that is expected after this time [s]: m + x cos(w t) - q sin(w t).
  Vec<6> After(double t) const;

  static FieldList Fields() {
    return {{"frequency", &WrenchSinusoid::frequency, "rad/s"},
            {"mean", &WrenchSinusoid::mean},
            {"in_phase", &WrenchSinusoid::in_phase},
            {"quadrature", &WrenchSinusoid::quadrature}};
  }
};

}  // namespace tenon
