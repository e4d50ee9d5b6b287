#pragma once

#include <tenon/controllers/legged/planning/planar_spline.h>
#include <tenon/controllers/legged/planning/support_polygon.h>
#include <tenon/controllers/optimization/dual_active_set.h>
#include <tenon/plants/model/gravity.h>
#include <tenon/plants/signals/motion_signals.h>

#include <Eigen/Core>

#include <array>
#include <span>
#include <utility>

namespace tenon {

/// The degree of a spline's polynomials.
enum class SplineOrder { kCubic, kQuintic };
constexpr auto EnumNames(SplineOrder) {
  return std::array{Named{SplineOrder::kCubic, "cubic"}, Named{SplineOrder::kQuintic, "quintic"}};
}

/// Weights are relative to that of the squared acceleration, which is one.
struct ZmpSplineParams {
  SplineOrder order = SplineOrder::kCubic;  ///< of the polynomials
  double path_weight = 10;                  ///< of the squared deviation from the path [1/s^4]
  double end_weight = 0.1;                  ///< of the squared error of the acceleration at the end [s]

  static FieldList Fields() {
    return {{"order", &ZmpSplineParams::order},
            {"path_weight_per_s4", &ZmpSplineParams::path_weight},
            {"end_weight_s", &ZmpSplineParams::end_weight}};
  }
  void Validate() const;  ///< throws ParameterError
};

/// A stretch of time in which the same feet stand.
struct SupportPhase {
  double duration = 0;  ///< [s]
  SupportPolygon polygon;
};

/// The prescribed height of the CoM above its feet: constant, after a cubic in time that fades.
struct HeightProfile {
  double rest = 0;               ///< [m]
  double fade_duration = 0;      ///< [s]
  std::array<double, 4> fade{};  ///< coefficients of t^0 ... t^3, until then [m/s^n]

  double At(double t) const;
  double Acceleration(double t) const;
};

/// What a spline is to do, from t = 0 on.
struct ZmpSplineProblem {
  std::span<const SupportPhase> phases;  ///< one after the other
  PlanarPoint begin{}, end{};            ///< of the end's, the acceleration is but wished for
  PlanarPath path{};                     ///< at t = 0
  HeightProfile height{};
  double gravity = kGravity;  ///< [m/s^2]
};

/// The motion of the CoM over ground as a spline whose zero moment point stays in the support polygons
/// (Morlando 2023, section 2.4.1). Of the motions x(t) that have the given position, velocity and
/// acceleration at the beginning, position and velocity at the end T, and no jump up to the acceleration,
///
///     min  integral of |x''|^2 + path_weight |x - path|^2 over [0, T]  +  end_weight |x''(T) - a_end|^2
///     a x_z + b y_z + c >= 0  for all edges of each polygon,   x_z = x - z x'' / (g + z''), eqs. (2.4),
///     (2.5)
///
/// with L' = 0 and the height z prescribed, so that it is a quadratic programme. The acceleration at the end
/// is not prescribed: that would fix the ZMP there.
///
/// Each phase has two cubic polynomials or one of degree five. In s = t / T_k, from 0 to 1 in segment k, the
/// acceleration is x''(s) = x''(0) + u_1 s (+ u_2 s^2 + u_3 s^3). Position, velocity and acceleration at a
/// segment's beginning are those at the end of the one before, so beginning and junctions are met by
/// construction, and the u are the variables, at most 54. The smoothness is integrated exactly, and so is the
/// deviation from a straight path by cubics; the other deviations by Gauss's rule of four points a segment.
/// The ZMP is bounded at kSamplesPerPhase times of each phase, evenly spaced and its end among them, and at
/// its beginning as well if another phase precedes. Between them it may leave the polygon by some x'' dt^2 /
/// 8, half a millimetre in a walk.
class ZmpSpline {
 public:
  static constexpr int kMaxPhases = 9;
  static constexpr int kSamplesPerPhase = 6;

  ZmpSpline();

  /// Writes `spline` if a solution was found. No allocation. Throws RunError if there are no phases or more
  /// than kMaxPhases.
  QpReport Solve(const ZmpSplineProblem& problem, const ZmpSplineParams& params, PlanarSpline* spline);

  /// The last problem, in all u of x, then all of y; and its solution.
  QuadraticProgram quadratic_program() const;
  const DualActiveSet& solver() const { return solver_; }

 private:
  static constexpr int kMaxPerCoordinate = 27;
  static constexpr int kMaxRows = kMaxPhases * (kSamplesPerPhase + 1) * SupportPolygon::kMaxFeet;
  /// Linear in the variables of one coordinate, with the constants of x and y in the last two columns.
  using Functional = Eigen::Matrix<double, 1, Eigen::Dynamic, Eigen::RowMajor, 1, kMaxPerCoordinate + 2>;

  void MakeSegments(const ZmpSplineProblem& problem);
  void AddCost(const ZmpSplineProblem& problem, double path_weight);
  void AddSquare(const Functional& f, const Eigen::Vector2d& target, double weight);
  void AddEnd(const ZmpSplineProblem& problem, double end_weight);
  void AddPolygons(const ZmpSplineProblem& problem);
  Functional Derivative(int order, int segment, double s) const;

  int segments_per_phase_ = 0, free_ = 0;  // variables per segment and coordinate
  int num_segments_ = 0, n_ = 0;           // variables per coordinate
  int rows_ = 0;                           // inequalities
  Eigen::Vector2d origin_ = Eigen::Vector2d::Zero();
  std::array<double, PlanarSpline::kMaxSegments> duration_{};
  Eigen::MatrixXd maps_;  // six rows a segment: its coefficients, as Functionals
  Eigen::MatrixXd H_;
  Eigen::VectorXd g_, b_eq_, b_in_;
  ConstraintMatrix A_eq_, A_in_;
  DualActiveSet solver_;
};

}  // namespace tenon
