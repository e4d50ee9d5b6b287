#pragma once

#include <tenon/systems/framework/block/state.h>
#include <tenon/systems/primitives/internal/elementwise.h>

namespace tenon {

template <internal::DoubleOrMatrix T = double>
struct PulseParams {
  T low = internal::Filled<T>(0);                           ///< y between pulses [unit]
  T high = internal::Filled<T>(1);                          ///< y during a pulse [unit]
  double start = 0;                                         ///< time of the first pulse [s]
  double width = std::numeric_limits<double>::infinity();   ///< width of a pulse [s]; infinity for a step
  double period = std::numeric_limits<double>::infinity();  ///< [s], more than width; infinity for one pulse
  std::string unit = "";                                    ///< unit of the output and its levels
  std::string elements = "";                                ///< names of the elements
  void Validate() const {
    Demand(internal::IsFinite(low) && internal::IsFinite(high), "low and high must be finite");
    Demand(std::isfinite(start), "start must be finite");
    Demand(width > 0, "width must be positive");
    Demand(period > width || (std::isinf(period) && std::isinf(width)), "period must exceed width");
  }
};

/// A step, a pulse, or a square wave:
///
///     y(t) = high for start + n period <= t < start + n period + width,   n = 0, 1, ...,   else low
///
/// T is double or Vec<N>. Every edge is a NextJump: integrator steps end there. Throws ParameterError if a
/// level or start is not finite, if width is not positive, or if period does not exceed width.
template <internal::DoubleOrMatrix T = double>
class Pulse final : public LeafSystem<PulseParams<T>> {
 public:
  using LeafSystem<PulseParams<T>>::LeafSystem;
  using LeafSystem<PulseParams<T>>::params;
  OutputPort<T> y{this, {"y", params.unit, params.elements}, Uses(this->time), [this](double t) -> const T& {
                    const double n = Count(t);
                    return n >= 0 && t < Fall(n) ? params.high : params.low;
                  }};
  NextJump next_edge{this, "next_edge", Uses(this->time), [this](double t) {
                       const double n = Count(t);
                       return n >= 0 && t < Fall(n) ? Fall(n) : Rise(n + 1);
                     }};

 private:
  double Rise(double n) const { return n > 0 ? params.start + n * params.period : params.start; }
  double Fall(double n) const { return Rise(n) + params.width; }
  /// Index of the last pulse that has begun; -1 before the first.
  double Count(double t) const {
    if (t < params.start) return -1;
    if (std::isinf(params.period)) return 0;
    double n = std::floor((t - params.start) / params.period);
    if (t < Rise(n)) --n;
    if (t >= Rise(n + 1)) ++n;
    return n;
  }
};

}  // namespace tenon
