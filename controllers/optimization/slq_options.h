#pragma once

#include <tenon/systems/framework/types/fields.h>

#include <array>
#include <utility>

namespace tenon {

/// How a continuous f(x, u) becomes x' = F(x, u) over a step, u constant.
enum class StepMethod { kEuler, kMidpoint, kRungeKutta4 };

constexpr auto EnumNames(StepMethod) {
  return std::array{Named{StepMethod::kEuler, "euler"}, Named{StepMethod::kMidpoint, "midpoint"},
                    Named{StepMethod::kRungeKutta4, "runge_kutta_4"}};
}

enum class SlqBounds {
  kProjectedNewton,    ///< the backward pass minimises over the box; inputs at a bound have no feedback
  kRollOutProjection,  ///< the backward pass knows no bounds; inputs are clamped in the roll-out (the thesis)
  kNone,               ///< there are none
};

constexpr auto EnumNames(SlqBounds) {
  return std::array{Named{SlqBounds::kProjectedNewton, "newton"},
                    Named{SlqBounds::kRollOutProjection, "projected"}, Named{SlqBounds::kNone, "none"}};
}

struct SlqOptions {
  StepMethod method = StepMethod::kRungeKutta4;
  SlqBounds bounds = SlqBounds::kProjectedNewton;
  int max_iterations = 1;   ///< of one Solve(); 1 is real-time iteration
  double tolerance = 1e-9;  ///< converged when the cost is expected to fall by less, relative to 1 + cost
};

enum class SlqStatus {
  kStepped,    ///< took all iterations that it was allowed, each of them a descent
  kConverged,  ///< the cost is expected to fall by less than the tolerance
  kNoDescent,  ///< no step along the search direction reduces the cost; the policy is the one before
  kNotFinite,  ///< the start or the roll-out is not finite; the policy is the one before
};

struct SlqReport {
  SlqStatus status = SlqStatus::kConverged;
  int iterations = 0;
  double initial_cost = 0;        ///< of the roll-out of the policy that it started from
  double cost = 0;                ///< of the policy that it leaves
  double expected_reduction = 0;  ///< by the last quadratic model, of a full step
  double step_length = 0;         ///< alpha of the last line search
  double regularisation = 0;      ///< mu of the last backward pass

  bool ok() const { return status == SlqStatus::kStepped || status == SlqStatus::kConverged; }
};

}  // namespace tenon
