#pragma once

#include <tenon/systems/errors.h>
#include <tenon/systems/random_stream.h>
#include <tenon/systems/signal.h>

#include <sstream>

namespace tenon {

/// Three independent normal numbers with the given standard deviations.
inline Vec<3> NormalVector(RandomStream& noise, const Vec<3>& deviation) {
  Vec<3> n;
  for (int i = 0; i < 3; ++i) n[i] = deviation[i] * noise.Normal();
  return n;
}

/// Throws ParameterError unless `deviation` can be one.
inline void CheckDeviation(const char* name, const Vec<3>& deviation) {
  if (deviation.allFinite() && deviation.minCoeff() >= 0) return;
  std::ostringstream text;
  text << name << " is (" << deviation[0] << ", " << deviation[1] << ", " << deviation[2]
       << "); a standard deviation is finite and not negative";
  throw ParameterError(text.str());
}

}  // namespace tenon
