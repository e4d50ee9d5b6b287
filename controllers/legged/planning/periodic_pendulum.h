#pragma once

#include <tenon/controllers/legged/planning/planar_point.h>
#include <tenon/plants/signals/motion_signals.h>

#include <array>

namespace tenon {

/// The motion of a linear inverted pendulum whose ZMP p rests at one point after the other,
///
///     x'' = w^2 (x - p),    w^2 = g / height,
///
/// that repeats itself from cycle to cycle along a path: cycle n + 1 is cycle n moved rigidly in the plane,
/// which holds for a robot that walks straight or in circles. There is one such motion.
///
/// In closed form: a = x + x'/w and b = x - x'/w obey a' = w (a - p) and b' = -w (b - p), so over a phase of
/// duration T that ends at a_T and begins at b_0
///
///     a(t) = p + (a_T - p) e^(-w (T - t)),    b(t) = p + (b_0 - p) e^(-w t);
///
/// no exponential grows. Around the cycle, end = rotation begin + translation gives a and b by two linear
/// equations each. (Takenaka et al. 2009 call a the divergent component of motion.)
class PeriodicPendulum {
 public:
  static constexpr int kMaxPhases = 8;
  struct Phase {
    double duration = 0;              ///< [s]
    Vec<2> zmp = Vec<2>::Zero();      ///< p, from the path's beginning [m]
    Vec<2> a_end = Vec<2>::Zero();    ///< [m]
    Vec<2> b_begin = Vec<2>::Zero();  ///< [m]

    static FieldList Fields() {
      return {{"duration", &Phase::duration, "s"},
              {"zmp", &Phase::zmp, "m"},
              {"a_end", &Phase::a_end, "m"},
              {"b_begin", &Phase::b_begin, "m"}};
    }
  };

  /// Begins anew, at rest over the path's beginning, until Solve. `frequency` is w [rad/s].
  void Begin(const PlanarPath& path, double frequency);
  /// The ZMP rests at `zmp_W` for `duration` seconds. At most kMaxPhases.
  void Add(double duration, const Eigen::Vector2d& zmp_W);
  /// The phases are a cycle, and the path goes on with its twist.
  void Solve();

  /// At the time t >= 0 after the beginning; in any later cycle too.
  PlanarPoint At(double t) const;
  /// p at that time, in W; where two phases meet, the later one's.
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
    double t;              // in it
    PlanarPath beginning;  // of the cycle
  };
  Place Find(double t) const;

  PlanarPath path_;
  double frequency_ = 1, cycle_ = 0;
  int num_phases_ = 0;
  std::array<Phase, kMaxPhases> phases_;
};

}  // namespace tenon
