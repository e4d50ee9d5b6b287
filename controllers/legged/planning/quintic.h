#pragma once

namespace tenon {

/// Position, velocity and acceleration of one coordinate.
struct MotionPoint {
  double position = 0, velocity = 0, acceleration = 0;
};

/// The polynomial of degree five that connects two points of motion within `duration` > 0, at time t from its
/// start.
inline MotionPoint Quintic(const MotionPoint& begin, const MotionPoint& end, double duration, double t) {
  const double T = duration, s = t / T;
  const double c0 = begin.position, c1 = T * begin.velocity, c2 = T * T * begin.acceleration / 2;
  // End conditions less the contribution of the terms up to s^2.
  const double p = end.position - c0 - c1 - c2;
  const double v = T * end.velocity - c1 - 2 * c2;
  const double a = T * T * end.acceleration - 2 * c2;
  const double c3 = 10 * p - 4 * v + a / 2;
  const double c4 = -15 * p + 7 * v - a;
  const double c5 = 6 * p - 3 * v + a / 2;
  return {c0 + s * (c1 + s * (c2 + s * (c3 + s * (c4 + s * c5)))),
          (c1 + s * (2 * c2 + s * (3 * c3 + s * (4 * c4 + s * 5 * c5)))) / T,
          (2 * c2 + s * (6 * c3 + s * (12 * c4 + s * 20 * c5))) / (T * T)};
}

}  // namespace tenon
