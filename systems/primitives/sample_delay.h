#pragma once

#include <tenon/systems/framework/block/state.h>

namespace tenon {

template <class T = double>
struct SampleDelayParams {
  int samples = 1;                    ///< length of the delay in periods, at least 1
  T initial = internal::Zeroed<T>();  ///< y before the first sample arrives [unit]
  Rate rate = Hz(1000);
  std::string unit = "";      ///< unit of input and output
  std::string elements = "";  ///< names of the elements
  void Validate() const {
    Demand(samples >= 1, "samples must be 1 or more: for a delay of 0, connect the ports directly");
    Demand(samples <= 1'000'000, "samples must be at most 1,000,000: each tick copies that many values");
  }
};

/// A delay by N samples, for transport and communication:
///
///     y[n] = u[n - N],   y[0] = … = y[N - 1] = initial
///
/// T is any copyable type except bool. The output does not depend on the present input, so the block breaks
/// loops. A tick copies N values and does not allocate if T does not. Throws ParameterError if N is below 1.
template <class T = double>
class SampleDelay final : public LeafSystem<SampleDelayParams<T>> {
  static_assert(!std::is_same_v<T, bool>, "SampleDelay: delay an int or an enumeration instead of a bool.");
  using Line = std::vector<T>;

 public:
  using LeafSystem<SampleDelayParams<T>>::LeafSystem;
  using LeafSystem<SampleDelayParams<T>>::params;
  InputPort<T> u{this, {"u", params.unit, params.elements}};
  /// The samples in transit, oldest first.
  DiscreteState<Line> line{
      this, {"line", params.unit, params.elements}, Line(params.samples, params.initial)};
  OutputPort<T> y{this,           {"y", params.unit, params.elements},
                  params.initial, Sampled{params.rate},
                  Uses(line),     [](const Line& old) -> const T& { return old.front(); }};
  Update<Line> next{line, Sampled{params.rate}, Uses(line, u),
                    [](const Line& old, const T& u_now, Line* out) {
                      out->resize(old.size());
                      std::copy(old.begin() + 1, old.end(), out->begin());
                      out->back() = u_now;
                    }};
};

}  // namespace tenon
