#pragma once

#include <tenon/systems/framework/diagram/diagram_builder.h>
#include <tenon/systems/primitives/sample_delay.h>

namespace tenon {

/// Delays `from` by `samples` periods with a block NAME_delay in `diagram`, whose output is `initial` until
/// the first value arrives. Returns the delayed output, or `from` if `samples` is 0.
template <class T>
const OutputPort<T>& Late(Subdiagram& diagram, const std::string& name, const OutputPort<T>& from,
                          const T& initial, Rate rate, int samples) {
  if (samples == 0) return from;
  auto& delay = diagram.Add<SampleDelay<T>>(
      name + "_delay", SampleDelayParams<T>{.samples = samples, .initial = initial, .rate = rate});
  diagram.Connect(from, delay.u);
  return delay.y;
}

}  // namespace tenon
