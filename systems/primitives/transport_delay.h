#pragma once

#include <tenon/systems/framework/block/state.h>
#include <tenon/systems/primitives/internal/elementwise.h>

namespace tenon {

template <internal::DoubleOrMatrix T = double>
struct TransportDelayParams {
  double delay = 0.1;                  ///< [s], at least the period
  T initial = internal::Filled<T>(0);  ///< y before the first sample arrives [unit]
  Rate rate = Hz(1000);                ///< rate of the samples
  std::string unit = "";               ///< unit of input and output
  std::string elements = "";           ///< names of the elements
  void Validate() const {
    Demand(delay >= rate.period() && std::isfinite(delay),
           "delay must be finite and not shorter than the period of rate: the input since the last sample is "
           "not known; use a higher rate");
    Demand(delay / rate.period() <= 1'000'000,
           "delay must not be longer than 1,000,000 periods of rate: each tick copies that many samples");
    Demand(internal::IsFinite(initial), "initial must be finite");
  }
};

/// The samples in transit through a TransportDelay.
template <class T>
struct TransportDelayLine {
  std::vector<T> samples = {};  ///< newest first
  std::size_t known = 0;        ///< number of samples taken, up to the length
  double newest = 0;            ///< time of the newest sample [s]
  static FieldList Fields() {
    return {{"samples", &TransportDelayLine::samples},
            {"known", &TransportDelayLine::known},
            {"newest", &TransportDelayLine::newest, "s"}};
  }
};

/// A delay by any time with a continuous output: samples of the input with linear interpolation.
///
///     y(t) = u(t - delay),   y = initial until the first sample has arrived
///
/// T is double or Vec<N>. With h the period, the error of y is at most h^2 / 8 max |d^2 u / dt^2|, and 0 at
/// the samples; a jump of u becomes a ramp of length h. If the delay is a multiple of h, y bends only at
/// ticks; otherwise it also bends between ticks, inside integrator steps: choose h accordingly where accuracy
/// matters. Use SampleDelay for sampled signals.
///
/// The output does not depend on the present input, so the block breaks loops. A tick copies delay / h values
/// and does not allocate. Throws ParameterError if the delay is shorter than h or not finite, or if the
/// initial value is not finite.
template <internal::DoubleOrMatrix T = double>
class TransportDelay final : public LeafSystem<TransportDelayParams<T>> {
 public:
  using LeafSystem<TransportDelayParams<T>>::LeafSystem;
  using LeafSystem<TransportDelayParams<T>>::params;
  using Line = TransportDelayLine<T>;
  InputPort<T> u{this, {"u", params.unit, params.elements}};
  DiscreteState<Line> line{this, "line", Line{.samples = std::vector<T>(Length(params), params.initial)}};
  OutputPort<T> y{this, {"y", params.unit, params.elements}, Uses(this->time, line), &TransportDelay::CalcY};
  Update<Line> next{line, Sampled{params.rate}, Uses(this->time, line, u),
                    [](double t, const Line& old, const T& u_now, Line* out) {
                      out->samples.resize(old.samples.size());
                      out->samples.front() = u_now;
                      std::copy(old.samples.begin(), old.samples.end() - 1, out->samples.begin() + 1);
                      out->known = std::min(old.known + 1, old.samples.size());
                      out->newest = t;
                    }};

 private:
  static std::size_t Length(const TransportDelayParams<T>& params) {
    return static_cast<std::size_t>(std::ceil(params.delay / params.rate.period())) + 1;
  }
  T CalcY(double t, const Line& old) const {
    const double periods = std::max((old.newest - t + params.delay) / params.rate.period(), 0.0);
    if (old.known == 0 || periods > static_cast<double>(old.known - 1)) return params.initial;
    const auto i = static_cast<std::size_t>(periods);
    const double w = periods - static_cast<double>(i);
    return (1 - w) * old.samples[i] + w * old.samples[std::min(i + 1, old.known - 1)];
  }
};

}  // namespace tenon
