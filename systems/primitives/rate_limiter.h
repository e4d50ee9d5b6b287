#pragma once

#include <tenon/systems/block.h>
#include <tenon/systems/primitives/internal/elementwise.h>

namespace tenon {

template <internal::DoubleOrMatrix T = double>
struct RateLimiterParams {
  T falling = internal::Filled<T>(-std::numeric_limits<double>::infinity());  ///< [unit/s], 0 or less
  T rising = internal::Filled<T>(std::numeric_limits<double>::infinity());    ///< [unit/s], 0 or more
  T initial = internal::Filled<T>(0);  ///< y before the first tick [unit]
  Rate rate = Hz(1000);
  std::string unit = "";      ///< unit of input and output
  std::string elements = "";  ///< names of the elements
  void Validate() const { Demand(internal::IsFinite(initial), "initial must be finite"); }
};

/// A sampled limit of the rate of change, element by element. With h the period:
///
///     y[n] = y[n - 1] + min(max(u[n] - y[n - 1], h falling), h rising),   y[-1] = initial
///
/// T is double or Vec<N>. Feedthrough at its ticks. Throws ParameterError if a limit has the wrong sign or is
/// not a number, or if the initial value is not finite.
template <internal::DoubleOrMatrix T = double>
class RateLimiter final : public LeafSystem<RateLimiterParams<T>> {
 public:
  using LeafSystem<RateLimiterParams<T>>::LeafSystem;
  using LeafSystem<RateLimiterParams<T>>::params;
  Parameter<T> falling{this,
                       {"falling", internal::Per(params.unit, "s"), params.elements},
                       params.falling,
                       "steepest fall",
                       Range().AtMost(0).OrInfinite()};
  Parameter<T> rising{this,
                      {"rising", internal::Per(params.unit, "s"), params.elements},
                      params.rising,
                      "steepest rise",
                      Range().AtLeast(0).OrInfinite()};
  InputPort<T> u{this, {"u", params.unit, params.elements}};
  DiscreteState<T> last{this, {"last", params.unit, params.elements}, params.initial};
  OutputPort<T> y{this,
                  {"y", params.unit, params.elements},
                  Sampled{params.rate},
                  Uses(last, u, falling, rising),
                  [this](const T& old, const T& u_now, const T& down, const T& up) -> T {
                    const auto limit = [h = params.rate.period()](double a, double b, double least,
                                                                  double most) {
                      const double step = b - a;
                      return step > h * most ? a + h * most : step < h * least ? a + h * least : b;
                    };
                    return internal::Elementwise(limit, old, u_now, down, up);
                  }};
  Update<T> next{last, Sampled{params.rate}, Uses(y), [](const T& v) -> const T& { return v; }};
};

}  // namespace tenon
