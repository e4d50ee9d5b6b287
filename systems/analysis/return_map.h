#pragma once

#include <tenon/systems/analysis/linearize_discrete.h>

#include <Eigen/Core>

#include <functional>
#include <map>
#include <string>
#include <vector>

namespace tenon {

/// A motion x*(t) that repeats itself after T, seen from a reference that may move on: P(x*) = x*, where the
/// return map P takes a state at one instant to the state T later, seen from where the reference then is.
/// Small deviations follow δx[k+1] = A δx[k]; the eigenvalues of A are the Floquet multipliers. The motion is
/// stable if all but the neutral ones are inside the unit circle.
struct ReturnMapResult {
  DiscreteLinearModel map;   ///< of P: A, x0 and x1 = P(x0), names, spread, flips; no inputs or outputs
  Eigen::VectorXd residual;  ///< P(x0) - x0: how far the run is from periodic
  /// Largest modulus first; those of the neutral directions apart.
  Eigen::VectorXcd multipliers, neutral_multipliers;
  /// What P moves out of the span of the neutral directions, relative to their length (each state in its
  /// scale): 0 if they are neutral as told.
  double neutral_defect = 0;
};

struct ReturnMapOptions {
  /// The period T [s] and the choice of states, steps and scales. For a motion with contacts, several large
  /// steps (1e-4, 2e-4, …): `map.spread` tells where they disagree. T is a multiple of all sample times; of a
  /// diagram whose samples alone repeat sooner, it has to be given.
  LinearizeDiscreteOptions map = {};
  int settle_periods = 0;  ///< run first, to come near the motion
  /// Before x1 is compared with x0: what a state gains in a period by its path and element ("robot.q.x").
  std::map<std::string, double> advance = {};
  /// The same by a function of x1 for what is no constant: a heading that turns, an angle that wraps.
  std::function<Eigen::VectorXd(const Eigen::VectorXd&)> bring_back = nullptr;
  /// Directions along which the motion can be shifted and stays one, hence with a multiplier on the unit
  /// circle that tells nothing of stability: each is some states and how much they are shifted. A robot that
  /// walks anywhere as well has one along x, {{"robot.q.x", 1}, {"estimator.p_W.x", 1}}: all states that
  /// remember a place are in it.
  std::vector<std::map<std::string, double>> neutral = {};
  /// Besides, a shift in time, along ẋ: of diagrams that do not depend on time and sample nothing.
  bool time_is_neutral = false;
};

/// The return map of a periodic motion about a run that begins at a context, by central differences as
/// LinearizeDiscrete makes them and from the instant that it chooses. The context is left as it is.
///
/// Neutral directions V are set apart by the quotient: in an orthonormal basis that begins with those of V, A
/// is block triangular, and the multipliers are the eigenvalues of its last block (Y. A. Kuznetsov, Elements
/// of Applied Bifurcation Theory, 3rd ed. 2004, sec. 1.5 for multipliers and the one along ẋ).
///
/// Throws as LinearizeDiscrete does; ParameterError, with the nearest name, for a state that is not in the
/// map, for neutral directions that depend linearly on each other, and for a `bring_back` that changes how
/// many states there are.
ReturnMapResult ReturnMap(const Context& context, const ReturnMapOptions& options);

}  // namespace tenon
