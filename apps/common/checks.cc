#include <tenon/apps/common/checks.h>
#include <tenon/systems/framework/block/rate.h>
#include <tenon/systems/framework/types/errors.h>

#include <fmt/core.h>

namespace tenon::apps {

void DemandNear(const char* key, const Eigen::Vector3d& place_m) {
  constexpr double kFar = 100;
  if (place_m.allFinite() && place_m.cwiseAbs().maxCoeff() <= kFar) return;
  throw ParameterError(fmt::format("{} = [{:.10g}, {:.10g}, {:.10g}] must be within {} m", key, place_m[0],
                                   place_m[1], place_m[2], kFar));
}

namespace {

constexpr double kFastest = 1e5;  // Hz

/// Calls `check` and prefixes its ParameterError with the key.
void NameRefusal(const char* key, const auto& check) {
  try {
    check();
  } catch (const ParameterError& error) {
    throw ParameterError(fmt::format("{}: {}", key, error.what()));
  }
}

}  // namespace

void DemandRate(const char* key, double hz) {
  if (hz > kFastest) throw ParameterError(fmt::format("{} = {:.10g} must be at most {}", key, hz, kFastest));
  NameRefusal(key, [&] { Hz(hz); });
}

void DemandSamplePeriod(const char* key, double s) {
  if (!(s >= 1 / kFastest))
    throw ParameterError(fmt::format("{} = {:.4g} must be at least {}", key, s, 1 / kFastest));
  NameRefusal(key, [&] { Seconds(s); });
}

}  // namespace tenon::apps
