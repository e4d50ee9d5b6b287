#pragma once

#include <tenon/controllers/legged/planning/planar_point.h>
#include <tenon/systems/framework/types/fields.h>

#include <array>

namespace tenon {

/// A motion in the plane: polynomials in time of degree five at most, one after the other.
struct PlanarSpline {
  static constexpr int kMaxSegments = 18;
  struct Segment {
    double duration = 0;                 ///< T [s]
    std::array<Vec<2>, 6> coefficients;  ///< of (t/T)^0 ... (t/T)^5, t in the segment; from the origin [m]

    Segment() { coefficients.fill(Vec<2>::Zero()); }
    static FieldList Fields() {
      return {{"duration", &Segment::duration, "s"}, {"coefficients", &Segment::coefficients, "m"}};
    }
  };

  Vec<2> origin = Vec<2>::Zero();  ///< so that a distant robot loses no digits [m]
  double duration = 0;             ///< of all segments [s]
  int num_segments = 0;
  std::array<Segment, kMaxSegments> segments;

  /// At the time t after the beginning. Before and after the spline its first and last polynomial go on.
  PlanarPoint At(double t) const;

  static FieldList Fields() {
    return {{"origin", &PlanarSpline::origin, "m"},
            {"duration", &PlanarSpline::duration, "s"},
            {"num_segments", &PlanarSpline::num_segments},
            {"segments", &PlanarSpline::segments}};
  }
};

}  // namespace tenon
