#include <tenon/apps/common/checks.h>

#include <fmt/core.h>

#include <cmath>

#include <tenon/systems/framework/errors.h>
#include <tenon/systems/framework/rate.h>

namespace tenon::apps {

void DemandPositive(const char* key, double value) {
  if (std::isfinite(value) && value > 0) return;
  throw ParameterError(fmt::format("{} = {} must be positive and finite", key, value));
}

void DemandNotNegative(const char* key, double value) {
  if (std::isfinite(value) && value >= 0) return;
  throw ParameterError(fmt::format("{} = {} must be finite and not negative", key, value));
}

void DemandNear(const char* key, const Eigen::Vector3d& place_m) {
  constexpr double kFar = 100;
  if (place_m.allFinite() && place_m.cwiseAbs().maxCoeff() <= kFar) return;
  throw ParameterError(
      fmt::format("{} = [{}, {}, {}] must be within {} m", key, place_m[0], place_m[1], place_m[2], kFar));
}

void DemandRate(const char* key, double hz) {
  constexpr double kMost = 1e5;
  if (hz > kMost)
    throw ParameterError(
        fmt::format("{} = {} must be at most {}: nothing on a robot is sampled faster", key, hz, kMost));
  try {
    Hz(hz);
  } catch (const ParameterError& error) {
    throw ParameterError(fmt::format("{}: {}", key, error.what()));
  }
}

void DemandBetween(const char* key, double value, double low, double high) {
  if (value >= low && value <= high) return;
  throw ParameterError(fmt::format("{} = {} must be from {} to {}", key, value, low, high));
}

}  // namespace tenon::apps
