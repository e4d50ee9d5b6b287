#pragma once

#include <tenon/controllers/cdpr/inverse_geometrico_static.h>
#include <tenon/systems/framework/types/fields.h>

#include <Eigen/Core>

#include <memory>
#include <optional>
#include <vector>

namespace tenon {

/// A point of a path, with its derivatives in time.
struct PathPoint {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();      ///< [m]
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();      ///< [m/s]
  Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();  ///< [m/s^2]
};

/// A path of the CoM in W that starts at rest, with continuous position, velocity and acceleration.
///
/// A path is a curve p(s) that is run through as s(t). On a circle s is the angle [rad]; on every other path
/// it is the time. Before its start a path rests at its first point, after its end at its last. The functions
/// that make paths throw a ParameterError that names the invalid number.
class Path {
 public:
  /// Returns an endless circle about `center` from center + radius `along` to center + radius `across` and
  /// on; these are unit vectors at right angles. By default it is horizontal and counter-clockwise. The
  /// angular rate grows from zero to 2 pi / period within `ramp` [s], as 10 x^3 - 15 x^4 + 6 x^5 of x = t /
  /// ramp; during the ramp, the path covers half of the angle that it would cover at full rate.
  static Path Circle(const Eigen::Vector3d& center, double radius, double period, double ramp,
                     const Eigen::Vector3d& along = Eigen::Vector3d::UnitX(),
                     const Eigen::Vector3d& across = Eigen::Vector3d::UnitY());

  /// Returns a line from rest to rest: p = from + (to - from) (10 x^3 - 15 x^4 + 6 x^5), x = t / duration.
  static Path Line(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double duration);

  /// Returns the quintic spline with four continuous derivatives through `points` at `times` [s], from rest
  /// to rest. It minimises the integral of the squared jerk and does not stop at the points.
  static Path Spline(const std::vector<Eigen::Vector3d>& points, const std::vector<double>& times);

  /// Returns splines from rest to rest. At two equal successive points the path rests from the time of the
  /// first to that of the second. Position, velocity and acceleration are continuous everywhere.
  static Path Waypoints(const std::vector<Eigen::Vector3d>& points, const std::vector<double>& times);

  /// Returns a quintic from the motion `from` at `start` [s] to rest at `to` at `end` [s]; undefined before
  /// `start`.
  static Path Move(const PathPoint& from, double start, const Eigen::Vector3d& to, double end);

  static Path Hold(const Eigen::Vector3d& position);

  PathPoint At(double time) const;

  bool is_periodic() const { return period_ > 0; }
  double start_time() const { return times_.front(); }
  double end_time() const;  ///< time at which the path comes to rest [s]; infinite for a circle

  /// The parameter s and its derivatives at a time; constant before the start and after the end.
  struct Parameter {
    double value, rate, acceleration;
  };
  Parameter ParameterAt(double time) const;
  Eigen::Vector3d PositionOf(double parameter) const;
  double TimeOf(double parameter) const;  ///< the first time at which s(t) = parameter

 private:
  Path() = default;

  // Polynomials between times_[i] and times_[i + 1]; column k is the coefficient of (t - times_[i])^k.
  using Quintic = Eigen::Matrix<double, 3, 6>;
  std::vector<double> times_{0.0};
  std::vector<Quintic> pieces_;
  Eigen::Vector3d center_ = Eigen::Vector3d::Zero();  // centre of the circle, or the point of Hold()
  double radius_ = 0, period_ = 0, ramp_ = 0;         // parameters of the circle
  Eigen::Vector3d along_ = Eigen::Vector3d::UnitX(), across_ = Eigen::Vector3d::UnitY();
};

/// The quasi-static reference at a time.
struct CdprReference {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();      ///< position of the CoM, in W [m]
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();      ///< [m/s]
  Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();  ///< [m/s^2]
  Eigen::Vector3d euler = Eigen::Vector3d::Zero();         ///< ZYX [rad]
  Eigen::Vector3d euler_rate = Eigen::Vector3d::Zero();    ///< [rad/s]
  CableVector length, length_rate;                         ///< lengths and rates at pose and twist [m, m/s]
  CableVector tension;                                     ///< tensions of the equilibrium at `position` [N]

  static FieldList Fields() {
    return {{"position", &CdprReference::position, "m"},
            {"velocity", &CdprReference::velocity, "m/s"},
            {"acceleration", &CdprReference::acceleration, "m/s^2"},
            {"euler", &CdprReference::euler, "rad"},
            {"euler_rate", &CdprReference::euler_rate, "rad/s"},
            {"length", &CdprReference::length, "m"},
            {"length_rate", &CdprReference::length_rate, "m/s"},
            {"tension", &CdprReference::tension, "N"}};
  }
};

/// The equilibria along a path, found before the run and interpolated during it (Morlando 2023, sec. 3.5.2).
///
/// At closely spaced s (every half degree on a circle, at most every 20 ms on other paths), the attitude
/// Theta(s) and the tensions u(s) are computed by SolveInverseGeometricoStatic(). Each solution starts from
/// the previous one, so that the attitude stays on one branch of equilibria. A cubic spline with two
/// continuous derivatives interpolates them; on a circle it is periodic. The cable lengths are not
/// interpolated but computed from the pose:
///
///     l_i(t)     = |a_i - p(t) - R(Theta(t)) r_i|
///     dl_i/dt    = -(W column i) . [v ; w],    v = dp/dt,   w = E(Theta) dTheta/ds ds/dt
///
/// The reference is quasi-static: u does not contain the forces that accelerate the platform. Where a tension
/// reaches a bound, Theta(s) has a kink, which the spline smooths over two or three nodes.
///
/// For a controller with a wrong model of the robot, pass the description of that model.
class EquilibriumPath {
 public:
  /// The options apply to each equilibrium, their warm start to the first point. `attitude`, if given, is the
  /// path of roll, pitch, yaw [rad] and replaces the attitude of the options; not for circles. Throws
  /// ParameterError with the time, the point and the reason if a point of the path has no equilibrium, or if
  /// the branch ends there, so that the attitude would jump.
  EquilibriumPath(const CdprDescription& robot, const Path& path, const StaticsOptions& options = {},
                  const std::optional<Path>& attitude = {});

  /// Computes the reference at any time. Takes less than 2 us for four cables and does not allocate if
  /// `reference` has been filled for the same number of cables.
  void At(double time, CdprReference* reference) const;
  CdprReference At(double time) const;

  const Path& path() const { return path_; }
  const CdprDescription& robot() const { return robot_; }
  /// Options of the equilibria, with the attitude at the start if it is prescribed.
  const StaticsOptions& options() const { return options_; }
  int num_nodes() const { return static_cast<int>(values_.cols()); }

 private:
  void FitSlopes();

  CdprDescription robot_;
  Path path_;
  StaticsOptions options_;
  double first_ = 0, step_ = 1;  // s of the first node, spacing of the nodes
  // Roll, pitch, yaw and the tensions, one column per node: values and derivatives with respect to s.
  Eigen::MatrixXd values_, slopes_;
};

/// A path chosen during a run; null selects the path of the block's parameters. It contains no numbers, so
/// logs and snapshots omit it, and GoalPath recomputes it.
struct FollowedPath {
  std::shared_ptr<const EquilibriumPath> path;

  static FieldList Fields() { return {Undescribed(&FollowedPath::path)}; }
};

}  // namespace tenon

TENON_DECLARE_SIGNAL(tenon::CdprReference);
