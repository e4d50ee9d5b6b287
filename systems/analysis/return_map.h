#pragma once

#include <tenon/systems/analysis/linearize_discrete.h>

namespace tenon {

/// A motion x*(t) that repeats itself after the period T relative to a reference that may move: P(x*) = x*,
/// where the return map P maps a state to the state one period later, relative to the reference at that time.
/// Small deviations follow δx[k+1] = A δx[k]; the eigenvalues of A are the Floquet multipliers. The motion is
/// stable if all multipliers except the neutral ones are inside the unit circle.
struct ReturnMapResult {
  DiscreteLinearModel map;   ///< linearised P: A, x0, x1 = P(x0), names, spread, flips; no inputs or outputs
  Eigen::VectorXd residual;  ///< P(x0) - x0, the deviation from a periodic motion
  /// Sorted by descending modulus; those of the neutral directions are separate.
  Eigen::VectorXcd multipliers, neutral_multipliers;
  /// Part of the images of the neutral directions outside their span, relative to their length (each state
  /// divided by its scale): 0 if they are neutral.
  double neutral_defect = 0;
};

struct ReturnMapOptions {
  /// The period T [s] and the choice of states, steps and scales. For a motion with contacts, use several
  /// large steps (1e-4, 2e-4, …); `map.spread` shows where they disagree. T must be a multiple of all sample
  /// times. It must be given if it is longer than their common period.
  LinearizeDiscreteOptions map = {};
  int settle_periods = 0;  ///< number of periods to run first, to approach the motion
  /// Advance of a state per period, by path and element ("robot.q.x"); subtracted before x1 is compared with
  /// x0.
  std::map<std::string, double> advance = {};
  /// Function of x1 for an advance that is not constant, such as of a turning heading or an angle that wraps.
  std::function<Eigen::VectorXd(const Eigen::VectorXd&)> bring_back = nullptr;
  /// Directions along which the motion can be shifted, which have a multiplier on the unit circle that does
  /// not indicate instability. Each is given by states and their shifts. A robot whose walk does not depend
  /// on its place has one along x, {{"robot.q.x", 1}, {"estimator.p_W.x", 1}}, which contains all states that
  /// depend on the place.
  std::vector<std::map<std::string, double>> neutral = {};
  /// Adds the shift in time, along ẋ, for diagrams without samples that do not depend on time.
  bool time_is_neutral = false;
};

/// Computes the return map of a periodic motion about a run that begins at a context, by central differences
/// and with the begin of the period as in LinearizeDiscrete. The context is left unchanged.
///
/// Neutral directions V are separated by the quotient: in an orthonormal basis that begins with a basis of V,
/// A is block triangular, and the multipliers are the eigenvalues of its last block (Y. A. Kuznetsov,
/// Elements of Applied Bifurcation Theory, 3rd ed. 2004, sec. 1.5 for multipliers and the one along ẋ).
///
/// Throws as LinearizeDiscrete does, and ParameterError for an unknown state (with the nearest name),
/// linearly dependent neutral directions, and a `bring_back` that changes the number of states.
ReturnMapResult ReturnMap(const Context& context, const ReturnMapOptions& options);

}  // namespace tenon
