#pragma once

#include <tenon/systems/framework/context/context.h>
#include <tenon/systems/framework/diagram/diagram.h>

namespace tenon {

/// The linear model ẋ = ẋ0 + A (x - x0) + B (u - u0), y = y0 + C (x - x0) + D (u - u0), with named rows and
/// columns. Units are those of the signals.
struct LinearModel {
  Eigen::MatrixXd A, B, C, D;
  Eigen::VectorXd x0, u0, y0, xdot0;
  std::vector<std::string> states, inputs, outputs;
};

/// Linearises a diagram about a context's values by central differences. x is the diagram's continuous state;
/// time, discrete states and samples are constant. `inputs` are open inputs or sampled outputs, whose held
/// value is varied, so that a plant inside a digital loop can be linearised from its command. `outputs` are
/// any ports. Only real numbers of inputs are varied; bools, integers and enumerations have no column. The
/// context is left unchanged.
///
/// Throws RunError if an input cannot be set, for a diagram with samples but without continuous state (use
/// LinearizeDiscrete), and at a kink or a jump, such as the limit of a saturation, where no derivative
/// exists. A kink is detected by one-sided slopes that differ by 0.1 % and more than rounding errors, also
/// when the step of 1e-6 (1 + |value|) is reduced. In that case, linearise beside the kink. This check at
/// most doubles the number of evaluations, and only if slopes differ or values change much within a step.
LinearModel Linearize(const Context& context, const std::vector<const Source*>& inputs,
                      const std::vector<const Source*>& outputs);

struct EquilibriumOptions {
  double tolerance = 1e-10;  ///< tolerance of the norm of ẋ [SI units]
  int max_iterations = 200;
  /// Open inputs or samples whose real numbers may be changed as well (trim).
  std::vector<const Source*> free_inputs = {};
};

/// Changes a context's continuous states and free inputs until ẋ = 0 at its time, with constant samples and
/// discrete states, by the Levenberg-Marquardt method from the context's present values. In a family of
/// equilibria it finds a near one. If there is none, throws RunError that names the largest remaining
/// derivative.
void FindEquilibrium(Context& context, const EquilibriumOptions& options = {});

}  // namespace tenon
