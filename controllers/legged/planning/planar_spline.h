#pragma once

#include <tenon/controllers/legged/planning/planar_point.h>
#include <tenon/systems/framework/types/fields.h>

#include <array>

namespace tenon {

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
  PlanarPoint At(double t) const;

  static FieldList Fields() {
    return {{"origin", &PlanarSpline::origin, "m"},
            {"duration", &PlanarSpline::duration, "s"},
            {"num_segments", &PlanarSpline::num_segments},
            {"segments", &PlanarSpline::segments}};
  }
};

}  // namespace tenon
