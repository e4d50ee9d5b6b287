#pragma once

#include <tenon/systems/framework/types/signal.h>

namespace tenon {

/// Point of a motion in the plane, in W.
struct PlanarPoint {
  Vec<2> position = Vec<2>::Zero();      ///< x [m]
  Vec<2> velocity = Vec<2>::Zero();      ///< x' [m/s]
  Vec<2> acceleration = Vec<2>::Zero();  ///< x'' [m/s^2]

  static FieldList Fields() {
    return {{"position", &PlanarPoint::position, "m"},
            {"velocity", &PlanarPoint::velocity, "m/s"},
            {"acceleration", &PlanarPoint::acceleration, "m/s^2"}};
  }
};

/// Motion in the plane: a sequence of polynomials in time of degree up to five.
struct PlanarSpline {
  static constexpr int kMaxSegments = 18;
  struct Segment {
    double duration = 0;                 ///< T [s]
    std::array<Vec<2>, 6> coefficients;  ///< coefficients of (t/T)^0 ... (t/T)^5, relative to `origin` [m]

    Segment() { coefficients.fill(Vec<2>::Zero()); }
    static FieldList Fields() {
      return {{"duration", &Segment::duration, "s"}, {"coefficients", &Segment::coefficients, "m"}};
    }
  };

  Vec<2> origin = Vec<2>::Zero();  ///< reference point near the motion, for precision [m]
  double duration = 0;             ///< total duration [s]
  int num_segments = 0;
  std::array<Segment, kMaxSegments> segments;

  /// The motion at time t [s]; extrapolates the first and the last polynomial.
  PlanarPoint At(double t) const {
    PlanarPoint point;
    point.position = origin;
    if (num_segments == 0) return point;
    std::size_t k = 0;
    while (k + 1 < static_cast<std::size_t>(num_segments) && t >= segments[k].duration)
      t -= segments[k++].duration;
    // Horner's scheme for the polynomial and its two derivatives in s = t / T.
    const auto& c = segments[k].coefficients;
    const double T = segments[k].duration, s = t / T;
    Eigen::Vector2d p = c[5], v = Eigen::Vector2d::Zero(), half_a = Eigen::Vector2d::Zero();
    for (std::size_t i = 5; i-- > 0;) {
      half_a = half_a * s + v;
      v = v * s + p;
      p = p * s + c[i];
    }
    point.position += p;
    point.velocity = v / T;
    point.acceleration = 2 * half_a / (T * T);
    return point;
  }

  static FieldList Fields() {
    return {{"origin", &PlanarSpline::origin, "m"},
            {"duration", &PlanarSpline::duration, "s"},
            {"num_segments", &PlanarSpline::num_segments},
            {"segments", &PlanarSpline::segments}};
  }
};

/// Position, velocity and acceleration of one coordinate.
struct MotionPoint {
  double position = 0, velocity = 0, acceleration = 0;
};

/// Coefficients of s^0 to s^5, s = t / duration, of the polynomial of degree five that connects two points of
/// motion, such as MotionPoint or PlanarPoint, within `duration` > 0.
template <class Point>
auto QuinticCoefficients(const Point& begin, const Point& end, double duration) {
  using Position = decltype(begin.position);
  const double T = duration;
  std::array<Position, 6> c;
  c[0] = begin.position;
  c[1] = T * begin.velocity;
  c[2] = T * T * begin.acceleration / 2;
  // End conditions less the contribution of the terms up to s^2.
  const Position p = end.position - c[0] - c[1] - c[2];
  const Position v = T * end.velocity - c[1] - 2 * c[2];
  const Position a = T * T * end.acceleration - 2 * c[2];
  c[3] = 10 * p - 4 * v + a / 2;
  c[4] = -15 * p + 7 * v - a;
  c[5] = 6 * p - 3 * v + a / 2;
  return c;
}

/// The motion along this polynomial at time t from its start.
inline MotionPoint Quintic(const MotionPoint& begin, const MotionPoint& end, double duration, double t) {
  const double T = duration, s = t / T;
  const auto [c0, c1, c2, c3, c4, c5] = QuinticCoefficients(begin, end, T);
  return {c0 + s * (c1 + s * (c2 + s * (c3 + s * (c4 + s * c5)))),
          (c1 + s * (2 * c2 + s * (3 * c3 + s * (4 * c4 + s * 5 * c5)))) / T,
          (2 * c2 + s * (6 * c3 + s * (12 * c4 + s * 20 * c5))) / (T * T)};
}

}  // namespace tenon
