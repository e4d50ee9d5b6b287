#pragma once

#include <tenon/controllers/legged/planning/planar_spline.h>
#include <tenon/plants/signals/motion_signals.h>

namespace tenon {

/// The periodic motion of a linear inverted pendulum whose ZMP p is constant in each phase,
///
///     x'' = w^2 (x - p),    w^2 = g / height,
///
/// along a path: the motion of each cycle is that of the previous cycle after a rigid motion in the plane, as
/// for a robot that walks straight or in circles. The solution is unique.
///
/// In closed form: a = x + x'/w and b = x - x'/w obey a' = w (a - p) and b' = -w (b - p), so over a phase of
/// duration T that ends at a_T and begins at b_0
///
///     a(t) = p + (a_T - p) e^(-w (T - t)),    b(t) = p + (b_0 - p) e^(-w t);
///
/// without growing exponentials. The condition end = rotation begin + translation over a cycle yields two
/// linear equations each for a and b. (Takenaka et al. 2009 call a the divergent component of motion.)
class PeriodicPendulum {
 public:
  static constexpr int kMaxPhases = 8;
  struct Phase {
    double duration = 0;              ///< [s]
    Vec<2> zmp = Vec<2>::Zero();      ///< p, from the start of the path [m]
    Vec<2> a_end = Vec<2>::Zero();    ///< [m]
    Vec<2> b_begin = Vec<2>::Zero();  ///< [m]

    static FieldList Fields() {
      return {{"duration", &Phase::duration, "s"},
              {"zmp", &Phase::zmp, "m"},
              {"a_end", &Phase::a_end, "m"},
              {"b_begin", &Phase::b_begin, "m"}};
    }
  };

  /// Clears the phases; the motion rests at the start of the path until Solve(). `frequency` is w [rad/s].
  void Begin(const PlanarPath& path, double frequency);
  /// Adds a phase of `duration` seconds with the ZMP at `zmp_W`. Throws RunError for more than kMaxPhases.
  void Add(double duration, const Eigen::Vector2d& zmp_W);
  /// Computes the motion with the added phases as cycle, along the path with its constant twist.
  void Solve();

  /// The motion at time t >= 0 [s], in any cycle.
  PlanarPoint At(double t) const;
  /// The ZMP p at time t >= 0 in W [m]; at a junction, that of the later phase.
  Eigen::Vector2d ZmpAt(double t) const;

  static FieldList Fields() {
    return {{"path", &PeriodicPendulum::path_},
            {"frequency", &PeriodicPendulum::frequency_, "rad/s"},
            {"cycle", &PeriodicPendulum::cycle_, "s"},
            {"num_phases", &PeriodicPendulum::num_phases_},
            {"phases", &PeriodicPendulum::phases_}};
  }

 private:
  struct Place {
    const Phase* phase;    // null while at rest
    double t;              // time since the start of the phase
    PlanarPath beginning;  // path at the beginning of the cycle
  };
  Place Find(double t) const;

  PlanarPath path_;
  double frequency_ = 1, cycle_ = 0;
  int num_phases_ = 0;
  std::array<Phase, kMaxPhases> phases_;
};

}  // namespace tenon
