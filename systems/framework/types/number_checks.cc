#include <tenon/systems/framework/types/errors.h>
#include <tenon/systems/framework/types/number_checks.h>

#include <fmt/core.h>

#include <cmath>

namespace tenon {

void DemandPositive(const char* key, double value) {
  if (std::isfinite(value) && value > 0) return;
  throw ParameterError(fmt::format("{} = {:.10g} must be positive and finite", key, value));
}

void DemandNotNegative(const char* key, double value) {
  if (std::isfinite(value) && value >= 0) return;
  throw ParameterError(fmt::format("{} = {:.10g} must be finite and not negative", key, value));
}

void DemandBetween(const char* key, double value, double low, double high) {
  if (value >= low && value <= high) return;
  throw ParameterError(fmt::format("{} = {:.10g} must be from {} to {}", key, value, low, high));
}

}  // namespace tenon
