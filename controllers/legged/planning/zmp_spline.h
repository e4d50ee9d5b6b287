#pragma once

#include <tenon/controllers/legged/planning/planar_spline.h>
#include <tenon/controllers/legged/planning/support_polygon.h>
#include <tenon/controllers/optimization/dual_active_set.h>
#include <tenon/plants/model/rigid_inertia.h>
#include <tenon/plants/signals/motion_signals.h>

namespace tenon {

/// The degree of a spline's polynomials.
enum class SplineOrder { kCubic, kQuintic };

/// Weights relative to that of the squared acceleration, which is 1.
struct ZmpSplineParams {
  SplineOrder order = SplineOrder::kCubic;  ///< degree of the polynomials
  double path_weight = 10;                  ///< weight of the squared deviation from the path [1/s^4]
  double end_weight = 0.1;                  ///< weight of the squared acceleration error at the end [s]

  static FieldList Fields() {
    return {{"order", &ZmpSplineParams::order},
            Field("path_weight_per_s4", &ZmpSplineParams::path_weight).AtLeast(0),
            Field("end_weight_s", &ZmpSplineParams::end_weight).AtLeast(0)};
  }
};

/// A time interval with constant support.
struct SupportPhase {
  double duration = 0;  ///< [s]
  SupportPolygon polygon;
};

/// Prescribed height of the CoM above the feet: a constant plus a cubic in time that ends at fade_duration.
struct HeightProfile {
  double rest = 0;               ///< the constant [m]
  double fade_duration = 0;      ///< duration of the cubic [s]
  std::array<double, 4> fade{};  ///< coefficients of t^0 ... t^3 of the cubic [m/s^n]

  double At(double t) const;
  double Acceleration(double t) const;
};

/// Problem of ZmpSpline, starting at t = 0.
struct ZmpSplineProblem {
  std::span<const SupportPhase> phases;  ///< consecutive
  PlanarPoint begin{}, end{};            ///< boundary conditions; the final acceleration is only weighted
  PlanarPath path{};                     ///< path at t = 0
  const PlanarSpline* regularized = nullptr;  ///< a path instead of `path`, from t = 0 on
  HeightProfile height{};
  double gravity = kGravity;  ///< [m/s^2]
};

/// The horizontal motion of the CoM as a spline whose zero moment point stays in the support polygons
/// (Morlando 2023, section 2.4.1). Over motions x(t) with given initial position, velocity and acceleration,
/// given final position and velocity at T, and continuous acceleration,
///
///     min  integral of |x''|^2 + path_weight |x - path|^2 over [0, T]  +  end_weight |x''(T) - a_end|^2
///     a x_z + b y_z + c >= 0  for all edges of each polygon,   x_z = x - z x'' / (g + z''), eqs. (2.4),
///     (2.5)
///
/// with L' = 0 and prescribed height z, which makes it a quadratic program. The final acceleration is not
/// prescribed, since that would fix the final ZMP.
///
/// Each phase has two cubic polynomials or one of degree five. In segment k, with s = t / T_k from 0 to 1,
/// the acceleration is x''(s) = x''(0) + u_1 s (+ u_2 s^2 + u_3 s^3). Each segment starts with the final
/// position, velocity and acceleration of the previous one, so the initial and junction conditions hold by
/// construction, and the variables are the u, at most 54. The integral is exact for the acceleration, and for
/// the deviation of cubics from a straight path; other deviations use Gauss-Legendre quadrature with four
/// points a segment. The ZMP is constrained at kSamplesPerPhase times of each phase, evenly spaced up to its
/// end, and also at its start if it follows another phase. Between these times it may leave the polygon by
/// about x'' dt^2 / 8, half a millimetre in a walk.
class ZmpSpline {
 public:
  static constexpr int kMaxPhases = 9;
  static constexpr int kSamplesPerPhase = 6;

  ZmpSpline();

  /// Writes `spline` if the solve succeeds. Does not allocate. Throws RunError for no phases or more than
  /// kMaxPhases.
  QpReport Solve(const ZmpSplineProblem& problem, const ZmpSplineParams& params, PlanarSpline* spline);

  /// The quadratic program of the last Solve(), in the u of x, then of y.
  QuadraticProgram quadratic_program() const;
  const DualActiveSet& solver() const { return solver_; }

 private:
  static constexpr int kMaxPerCoordinate = 27;
  static constexpr int kMaxRows = kMaxPhases * (kSamplesPerPhase + 1) * SupportPolygon::kMaxFeet;
  /// Affine function of the variables of one coordinate, with the constants of x and y in the last two
  /// columns.
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
