#pragma once

#include <tenon/systems/framework/context/context.h>
#include <tenon/systems/framework/diagram/diagram.h>

#include <Eigen/Core>

#include <string>
#include <vector>

namespace tenon {

/// ẋ = ẋ0 + A (x - x0) + B (u - u0), y = y0 + C (x - x0) + D (u - u0). Rows and columns are named; units are
/// those of the signals.
struct LinearModel {
  Eigen::MatrixXd A, B, C, D;
  Eigen::VectorXd x0, u0, y0, xdot0;
  std::vector<std::string> states, inputs, outputs;
};

/// Linearises a diagram about a context's values, by central differences. x is the diagram's continuous
/// state, with time, discrete states and samples held; `inputs` are open inputs or sampled outputs (of which
/// the diagram holds the value: so a plant inside a digital loop can be linearised from its command),
/// `outputs` any ports. Of inputs the real numbers are moved; bools, integers and enumerations stay and have
/// no column. The context is left as it is.
///
/// Throws RunError if an input cannot be set; for a diagram that has samples and no continuous state: that is
/// for LinearizeDiscrete; and at a kink or a jump, say at the limit of a saturation, where there is no
/// derivative. It sees them by slopes that differ from one side to the other (by 0.1 %, and by more than
/// rounding errors do) and go on to differ as the step, 1e-6 (1 + |value|), becomes smaller. Linearise beside
/// the kink then: the model is that of the side. This costs evaluations only where slopes differ or values
/// change much within a step, as they do near 0: twice as many as without, at most.
LinearModel Linearize(const Context& context, const std::vector<const Source*>& inputs,
                      const std::vector<const Source*>& outputs);

struct EquilibriumOptions {
  double tolerance = 1e-10;  ///< on the norm of ẋ [SI units]
  int max_iterations = 200;
  /// Open inputs or samples whose real numbers may change too (trim); all others stay.
  std::vector<const Source*> free_inputs = {};
};

/// Changes a context's continuous states (and free inputs) until ẋ = 0 at its time, with samples and discrete
/// states held, by the Levenberg-Marquardt method from where the context is. Among equilibria of a family it
/// goes to a near one. Throws RunError that names the derivative that stays largest if there is none near.
void FindEquilibrium(Context& context, const EquilibriumOptions& options = {});

}  // namespace tenon
