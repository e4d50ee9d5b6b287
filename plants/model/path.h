#pragma once

#include <tenon/plants/model/cdpr_description.h>

namespace tenon {

/// A point of a path, with its derivatives in time.
struct PathPoint {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();      ///< [m]
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();      ///< [m/s]
  Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();  ///< [m/s^2]
};

/// A path of a point in W that starts at rest, with continuous position, velocity and acceleration.
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

/// The anchors of a cable robot that move during a run, on cranes or gantries, see AnchorPath.
///
/// Only the difference between the places of an anchor and of the platform decides the course of a cable. An
/// anchor that has moved by d therefore acts like one that stands while the platform has moved by -d, but
/// the ends of its cable in the world move by d.
class MovingAnchors {
 public:
  MovingAnchors() = default;  ///< all anchors stand
  /// @throws ParameterError if the path of an anchor is not valid.
  explicit MovingAnchors(const CdprDescription& robot);

  bool any() const { return !paths_.empty(); }  ///< whether an anchor of the robot moves
  double start_time() const { return start_; }  ///< time at which the first anchor begins to move [s]
  double end_time() const { return end_; }      ///< time from which on all anchors stand [s]

  /// Displacement of an anchor from its `anchor_W`, with its derivatives. Does not allocate.
  PathPoint At(int cable, double time) const {
    return any() && paths_[cable] ? paths_[cable]->At(time) : PathPoint{};
  }

  /// Returns `robot` with its anchors at their places at this time, where they stand.
  CdprDescription RobotAt(const CdprDescription& robot, double time) const;

 private:
  std::vector<std::optional<Path>> paths_;  // one per cable; empty if all anchors stand
  double start_ = 0, end_ = 0;
};

}  // namespace tenon
