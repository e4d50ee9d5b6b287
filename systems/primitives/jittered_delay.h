#pragma once

#include <tenon/systems/framework/block/state.h>
#include <tenon/systems/primitives/internal/elementwise.h>

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <string>
#include <vector>

namespace tenon {

template <class T = double>
struct JitteredDelayParams {
  double delay = 0.001;               ///< mean [s]
  double jitter = 0;                  ///< delays lie within delay ± jitter, evenly [s]
  T initial = internal::Zeroed<T>();  ///< held before the first message arrives [unit]
  Rate rate = Hz(1000);               ///< of the messages
  std::string unit = "";              ///< of input and output
  std::string elements = "";          ///< names of their elements
  void Validate() const {
    Demand(std::isfinite(delay) && jitter >= 0 && delay >= jitter,
           "delay must be finite and jitter from 0 to delay: no message arrives before it is sent");
    Demand((delay + jitter) / rate.period() <= 10'000,
           "delay + jitter must not be longer than 10,000 periods: that many messages would be on their way");
    Demand(internal::IsFinite(initial), "initial must be finite");
  }
};

/// What is on its way through a JitteredDelay, the newest first.
template <class T>
struct MessageLine {
  std::vector<T> values = {};
  std::vector<double> left = {};  ///< until each arrives; past, if negative [s]
  std::size_t known = 0;          ///< how many have been sent, up to the length of the line
  static FieldList Fields() {
    return {
        {"values", &MessageLine::values}, {"left", &MessageLine::left, "s"}, {"known", &MessageLine::known}};
  }
};

/// A link that takes messages at a rate and delivers each after a delay of its own, to a receiver that holds
/// the newest that it has: computing and a field bus between a controller and its drives.
///
///     a[n] = n h + delay + jitter e[n],   e[n] uniform in [-1, 1)          message n arrives
///     u*(t) = u[max {n: a[n] <= t}]                                        the receiver holds
///     y[k] = 1/h (integral of u* over k h <= t < (k + 1) h)                and this is what it comes to
///
///     | port | kind            | size | unit |
///     | u    | input           | T    | unit |
///     | y    | output, sampled | T    | unit |
///
/// A message that is overtaken is lost. y has each message's impulse exactly, and so what receives it, if it
/// is slow against h, goes as if the messages came between the ticks; no tick of a finer rate interrupts the
/// integration. With a delay below h + jitter the output depends on the present input. SampleDelay is the
/// block for delays of whole periods without jitter, TransportDelay for signals that are not sampled.
///
/// T is double, a Vec<N> or a vector of run-time size, which `initial` gives. A tick copies the messages that
/// are on their way and allocates nothing. Throws ParameterError unless 0 <= jitter <= delay, finite.
template <class T = double>
class JitteredDelay final : public LeafSystem<JitteredDelayParams<T>> {
  static_assert(internal::DoubleOrMatrix<T> || internal::VectorOfRunTimeSize<T>,
                "JitteredDelay: T is double, a Vec<N> or a vector of run-time size.");

 public:
  using LeafSystem<JitteredDelayParams<T>>::LeafSystem;
  using LeafSystem<JitteredDelayParams<T>>::params;
  using Line = MessageLine<T>;
  InputPort<T> u{this, {"u", params.unit, params.elements}};
  Random random{this, "random"};
  Scratch<Line> line{this, "line",
                     Line{.values = std::vector<T>(Length(params), params.initial),
                          .left = std::vector<double>(Length(params))}};
  OutputPort<T> y{this,
                  {"y", params.unit, params.elements},
                  params.initial,
                  Sampled{params.rate},
                  Uses(u, random, line),
                  &JitteredDelay::CalcY};

 private:
  /// A message that leaves the line has arrived.
  static std::size_t Length(const JitteredDelayParams<T>& params) {
    return static_cast<std::size_t>(std::ceil((params.delay + params.jitter) / params.rate.period())) + 1;
  }
  void CalcY(const T& u, RandomStream& random, Line& line, T* y) const {
    const double h = params.rate.period();
    line.known = std::min(line.known + 1, line.values.size());
    for (std::size_t i = line.known - 1; i > 0; --i) {
      line.values[i] = line.values[i - 1];
      line.left[i] = line.left[i - 1] - h;
    }
    line.values[0] = u;
    line.left[0] = params.delay + (params.jitter > 0 ? params.jitter * random.Uniform(-1, 1) : 0);
    // From the end of the tick to its beginning: what came last holds to the end, what came before until
    // then.
    double open = 1;  // part of the tick, its beginning, of which it is not known yet what holds
    *y = 0 * u;
    for (std::size_t i = 0; i < line.known && open > 0; ++i) {
      const double from = std::max(line.left[i] / h, 0.0);
      if (from >= open) continue;
      *y += (open - from) * line.values[i];
      open = from;
    }
    if (open > 0) *y += open * params.initial;
  }
};

}  // namespace tenon
