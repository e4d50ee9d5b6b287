#include <tenon/plants/legged/drive_errors.h>

namespace tenon {

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
