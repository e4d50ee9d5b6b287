#pragma once

#include <tenon/controllers/cdpr/inverse_geometrico_static.h>

namespace tenon {

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
/// With moving anchors (AnchorPath), s is the time on all paths, and the equilibria cover the times until
/// both the platform and the anchors have come to rest. The anchors' velocities count in dl_i/dt. A circle
/// has no end, so that it cannot be combined with moving anchors.
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
  const MovingAnchors& anchors() const { return anchors_; }
  /// Options of the equilibria, with the attitude at the start if it is prescribed.
  const StaticsOptions& options() const { return options_; }
  int num_nodes() const { return static_cast<int>(values_.cols()); }

 private:
  void FitSlopes();

  CdprDescription robot_;
  MovingAnchors anchors_;
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
