#pragma once

#include <tenon/systems/framework/block/state.h>
#include <tenon/systems/primitives/internal/elementwise.h>

namespace tenon {

template <internal::DoubleOrMatrix T = double>
struct IntegratorParams {
  T initial = internal::Filled<T>(0);  ///< y at t = 0 [y_unit]
  std::string u_unit = "";             ///< unit of the input: y_unit per second
  std::string y_unit = "";             ///< unit of the output
  std::string elements = "";           ///< names of the elements of u and y
  void Validate() const { Demand(internal::IsFinite(initial), "initial must be finite"); }
};

/// The integral over time:
///
///     dy/dt = u,   y(0) = initial
///
/// T is double or Vec<N>. The output does not depend on the present input, so the block breaks loops.
/// Throws ParameterError if the initial value is not finite.
template <internal::DoubleOrMatrix T = double>
class Integrator final : public LeafSystem<IntegratorParams<T>> {
 public:
  using LeafSystem<IntegratorParams<T>>::LeafSystem;
  using LeafSystem<IntegratorParams<T>>::params;
  InputPort<T> u{this, {"u", params.u_unit, params.elements}};
  ContinuousState<T> x{this, {"y", params.y_unit, params.elements}, params.initial};
  OutputPort<T> y{this, x};
  TimeDerivative<T> dx{x, u};
};

}  // namespace tenon
