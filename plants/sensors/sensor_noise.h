#pragma once

#include <tenon/systems/framework/block/random_stream.h>
#include <tenon/systems/framework/types/signal.h>

namespace tenon {

/// Three independent normal numbers with the given standard deviations.
inline Vec<3> NormalVector(RandomStream& noise, const Vec<3>& deviation) {
  Vec<3> n;
  for (int i = 0; i < 3; ++i) n[i] = deviation[i] * noise.Normal();
  return n;
}

/// Error of a sensor: a constant bias, and white noise with a component proportional to the signal. A signal
/// x is measured as
///
///     x + bias + (absolute + relative |x|) n,   n standard normal, drawn at each sample.
struct SensorError {
  double absolute = 0;  ///< standard deviation [unit of the signal]
  double relative = 0;  ///< standard deviation relative to the signal: 0.1 is 10 %
  double bias = 0;      ///< constant part [unit of the signal]

  static FieldList Fields() {
    return {Field("absolute", &SensorError::absolute).AtLeast(0).Because("a standard deviation, 0 for none"),
            Field("relative", &SensorError::relative).AtLeast(0).Because("a standard deviation, 0.1 is 10 %"),
            Field("bias", &SensorError::bias).Finite()};
  }

  /// The measured value. Draws no random number if there is no noise.
  double Measure(double x, RandomStream& noise) const {
    if (absolute == 0 && relative == 0) return x + bias;
    return x + bias + (absolute + relative * std::abs(x)) * noise.Normal();
  }
  /// The measured vector, with independent elements.
  template <int N>
  Vec<N> Measure(const Vec<N>& x, RandomStream& noise) const {
    Vec<N> y;
    for (int i = 0; i < N; ++i) y[i] = Measure(x[i], noise);
    return y;
  }
};

/// Parameters of a sensor whose samples arrive late. The diagram that contains the sensor delays them.
template <class Params>
struct Delayed : Params {
  int latency = 0;  ///< delay of the output [samples]

  static FieldList Fields() {
    return Params::Fields() + FieldList{Field("latency_samples", &Delayed::latency).Between(0, 10'000)};
  }
};

}  // namespace tenon
