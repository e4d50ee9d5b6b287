#pragma once

#include <tenon/systems/framework/types/fields.h>

namespace tenon {

/// Integration method of a step x' = F(x, u) of dx/dt = f(x, u), u constant.
enum class StepMethod { kEuler, kMidpoint, kRungeKutta4 };

enum class SlqBounds {
  kProjectedNewton,    ///< the backward pass minimises over the box; inputs at a bound have no feedback
  kRollOutProjection,  ///< the backward pass ignores the bounds; the roll-out clamps the inputs (the thesis)
  kNone,               ///< the bounds are ignored
};

constexpr auto EnumNames(SlqBounds) {
  return std::array{Named{SlqBounds::kProjectedNewton, "newton"},
                    Named{SlqBounds::kRollOutProjection, "projected"}, Named{SlqBounds::kNone, "none"}};
}

struct SlqOptions {
  StepMethod method = StepMethod::kRungeKutta4;    ///< integration method of the model
  SlqBounds bounds = SlqBounds::kProjectedNewton;  ///< handling of the bounds of the input
  int max_iterations = 1;   ///< maximum number of iterations per Solve(); 1 is the real-time iteration
  double tolerance = 1e-9;  ///< tolerance of the expected decrease of the cost, relative to 1 + cost
};

enum class SlqStatus {
  kStepped,    ///< reached max_iterations, each of which reduced the cost
  kConverged,  ///< the expected decrease of the cost is below the tolerance
  kNoDescent,  ///< no step along the search direction reduces the cost; the policy is unchanged
  kNotFinite,  ///< the start or the roll-out is not finite; the policy is unchanged
};

struct SlqReport {
  SlqStatus status = SlqStatus::kConverged;
  int iterations = 0;
  double initial_cost = 0;        ///< cost of the roll-out of the initial policy
  double cost = 0;                ///< cost of the final policy
  double expected_reduction = 0;  ///< cost reduction of a full step, by the last quadratic model
  double step_length = 0;         ///< alpha of the last line search
  double regularisation = 0;      ///< mu of the last backward pass

  bool ok() const { return status == SlqStatus::kStepped || status == SlqStatus::kConverged; }
};

}  // namespace tenon
