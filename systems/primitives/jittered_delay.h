#pragma once

#include <tenon/systems/framework/block/state.h>
#include <tenon/systems/primitives/internal/elementwise.h>

namespace tenon {

template <class T = double>
struct JitteredDelayParams {
  double delay = 0.001;               ///< mean delay [s]
  double jitter = 0;                  ///< delays are uniform in delay ± jitter [s]
  T initial = internal::Zeroed<T>();  ///< y before the first message arrives [unit]
  Rate rate = Hz(1000);               ///< rate of the messages
  std::string unit = "";              ///< unit of input and output
  std::string elements = "";          ///< names of the elements
  static FieldList Fields() {
    using P = JitteredDelayParams;
    return {Field("delay_s", &P::delay).AtLeast(0),
            Field("jitter_s", &P::jitter).AtLeast(0),
            Undescribed(&P::initial),
            Undescribed(&P::rate),
            Undescribed(&P::unit),
            Undescribed(&P::elements)};
  }
  void Validate() const {
    Demand(delay >= jitter, "jitter must be from 0 to delay: messages must not arrive before they are sent");
    Demand((delay + jitter) / rate.period() <= 10'000,
           "delay + jitter must not be longer than 10,000 periods: that many messages would be in transit");
    Demand(internal::IsFinite(initial), "initial must be finite");
  }
};

/// The messages in transit through a JitteredDelay, newest first.
template <class T>
struct MessageLine {
  std::vector<T> values = {};
  std::vector<double> left = {};  ///< time until each arrives, negative if it has arrived [s]
  std::size_t known = 0;          ///< number of messages sent, up to the length of the line
  static FieldList Fields() {
    return {
        {"values", &MessageLine::values}, {"left", &MessageLine::left, "s"}, {"known", &MessageLine::known}};
  }
};

/// A communication link that sends messages at a rate, delivers each with its own delay, and whose receiver
/// holds the newest message received. It models computation and a field bus between a controller and its
/// drives.
///
///     a[n] = n h + delay + jitter e[n],   e[n] uniform in [-1, 1)          arrival time of message n
///     u*(t) = u[max {n: a[n] <= t}]                                        value held by the receiver
///     y[k] = 1/h (integral of u* over k h <= t < (k + 1) h)                its mean over a period
///
/// A message that is overtaken is lost. y has exactly the impulse of each message, so a receiver that is slow
/// compared with h responds as if messages arrived between ticks, without finer ticks that would interrupt
/// the integration. With a delay below h + jitter the block has feedthrough. Use SampleDelay for delays of
/// whole periods without jitter, and TransportDelay for signals that are not sampled.
///
/// T is double, Vec<N> or a vector of run-time size, which `initial` sets. A tick copies the messages in
/// transit and does not allocate. Throws ParameterError unless 0 <= jitter <= delay, both finite.
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
  /// Longest possible number of messages in transit.
  static std::size_t Length(const JitteredDelayParams<T>& params) {
    return static_cast<std::size_t>(std::ceil((params.delay + params.jitter) / params.rate.period())) + 1;
  }
  void CalcY(const T& u_now, RandomStream& stream, Line& line_now, T* y_out) const {
    const double h = params.rate.period();
    line_now.known = std::min(line_now.known + 1, line_now.values.size());
    for (std::size_t i = line_now.known - 1; i > 0; --i) {
      line_now.values[i] = line_now.values[i - 1];
      line_now.left[i] = line_now.left[i - 1] - h;
    }
    line_now.values[0] = u_now;
    line_now.left[0] = params.delay + (params.jitter > 0 ? params.jitter * stream.Uniform(-1, 1) : 0);
    // Go backwards through the tick: the last message to arrive holds until the end, each earlier one until
    // the next.
    double open = 1;  // fraction of the tick, from its beginning, that is not yet assigned
    *y_out = 0 * u_now;
    for (std::size_t i = 0; i < line_now.known && open > 0; ++i) {
      const double from = std::max(line_now.left[i] / h, 0.0);
      if (from >= open) continue;
      *y_out += (open - from) * line_now.values[i];
      open = from;
    }
    if (open > 0) *y_out += open * params.initial;
  }
};

}  // namespace tenon
