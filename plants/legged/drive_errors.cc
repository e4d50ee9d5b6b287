#include <tenon/plants/legged/drive_errors.h>

#include <fmt/format.h>

#include <cmath>

namespace tenon {

void DriveErrorsParams::Validate() const {
  Demand(std::isfinite(gain_deviation) && gain_deviation >= 0 && gain_deviation < 1,
         fmt::format("gain_deviation = {} must be from 0 to below 1", gain_deviation));
  Demand(std::isfinite(ripple) && ripple >= 0 && ripple < 1,
         fmt::format("ripple = {} must be from 0 to below 1", ripple));
}

Vec<12> DriveErrors::Draw(RandomStream& random) const {
  Vec<12> gain;
  for (double& each : gain) each = params.gain_deviation * random.Normal();
  return gain;
}

Vec<12> DriveErrors::CalcTorque(const Vec<12>& command, const Vec<12>& gain, RandomStream& random) const {
  Vec<12> torque;
  for (int j = 0; j < kNumJoints; ++j)
    torque[j] = (1 + gain[j]) * (1 + params.ripple * random.Normal()) * command[j];
  return torque;
}

}  // namespace tenon
