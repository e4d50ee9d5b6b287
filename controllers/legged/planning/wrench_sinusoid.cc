#include <tenon/controllers/legged/planning/wrench_sinusoid.h>

#include <algorithm>

namespace tenon {

void WrenchSinusoid::Update(const Vec<6>& wrench, double dt) {
  constexpr double kDamping = 1.4, kOffset = 0.3,
                   kLock = 0.3;                  // k, k_m, g: damped, and found in a few periods
  constexpr double kNoise = 0.01;                // n
  constexpr double kSlowest = 1, kFastest = 25;  // [rad/s]
  const Vec<6> error = wrench - mean - in_phase;
  const double power = in_phase.squaredNorm() + quadrature.squaredNorm() + kNoise * kNoise;
  frequency -= dt * kLock * frequency * frequency * error.dot(quadrature) / power;
  frequency = std::clamp(frequency, kSlowest, kFastest);
  in_phase += dt * frequency * (kDamping * error - quadrature);
  quadrature += dt * frequency * in_phase;
  mean += dt * frequency * kOffset * error;
}

Vec<6> WrenchSinusoid::After(double t) const {
  return mean + std::cos(frequency * t) * in_phase - std::sin(frequency * t) * quadrature;
}

}  // namespace tenon
