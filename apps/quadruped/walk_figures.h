#pragma once

#include <tenon/apps/common/real_time.h>
#include <tenon/apps/quadruped/quadruped_scenario.h>
#include <tenon/diagrams/evaluation/leg_errors.h>
#include <tenon/diagrams/evaluation/tracking_error.h>
#include <tenon/diagrams/evaluation/walk_view.h>

namespace tenon::apps {

/// Errors of an estimated state. The tilt error is the angle between the true and the estimated vertical.
class StateErrors {
 public:
  void Add(const LeggedState& estimated, const LeggedState& truth);
  void AddTo(Summary& summary, const std::string& prefix = "") const;
  Tally drift, height_drift;  ///< errors of position and height [m]

 private:
  Tally velocity_, tilt_;  // [m/s], [rad]
  std::optional<double> position_end_;
};

/// Figures of the state estimate and of the walk relative to it (PathErrors), from a log of the true state,
/// the estimate and TrackingError::path. Without an estimator there are no figures. Position and yaw
/// drift, because no sensor measures them.
class EstimateFigures {
 public:
  explicit EstimateFigures(const QuadrupedWalk& loop) : loop_(loop) {}
  void Begin(const std::vector<std::string>& names);
  void Row(std::span<const double> row);
  void AddTo(Summary& summary) const;
  /// Adds the errors without drift, and the drift. Returns false if there is no estimator.
  bool AddPathTo(Summary& summary) const;

 private:
  const QuadrupedWalk& loop_;
  Logged<LeggedState> true_, estimated_;
  Logged<PathErrors> path_;
  StateErrors errors_;
  Tally path_errors_;  // [m]
  std::array<Tally, kNumLegs> path_foot_errors_;
};

/// Adds figures of the estimate of a force on a foot: its overshoot, relative to the force, and the time
/// after which it stays within 2 % of the force. The force must be the only one of the scenario, constant,
/// and act until the end at `duration` [s]. Other runs have no such figures.
void JudgeFootStep(const QuadrupedScenario& scenario, double duration, const QuadrupedWalk& loop,
                   Outputs& outputs);

/// Throws KeyError if the run ends at `end` [s], before `from` [s], the time from which it is judged. Its
/// figures would be null. If --duration has `cut` the run, this prints a warning instead.
void CheckJudged(double from, double end, bool cut = false);

/// Adds the block `leg_errors` to the diagram of a walk. Returns the port that shows the planned footholds,
/// or null if the planner does not tell them.
const OutputPort<Geometry>* AddLegErrors(DiagramBuilder& builder, const QuadrupedWalk& loop);

/// Figures of a walking robot, computed during the run from a log of every control tick.
///
/// Errors are those of QuadrupedWalk::errors. The error of the ground forces is the mean over all stance
/// phases without `kEdge` seconds at both ends of each phase. The slip of a foot is the distance that its
/// contact point moves along the ground in one stance phase. The climb is the largest height of the ground
/// under the trunk above that at the start. The work of the joints is the integral of the sum of |tau_i
/// qd_i|: drives that brake recover nothing. The rate of the torque is that from tick to tick, of all joints.
class WalkFigures final : public LogSink {
 public:
  static constexpr double kEdge = 0.012;  ///< [s]

  /// The shapes of a replay.
  static std::vector<const OutputPort<Geometry>*> Shapes(const QuadrupedWalk& loop) {
    std::vector<const OutputPort<Geometry>*> shapes{&loop.world.plant.geometry, &loop.view.geometry};
    if (const SlidingLoad* load = loop.world.sliding_load) shapes.push_back(&load->geometry);
    if (loop.ropes) shapes.push_back(&loop.ropes->geometry);
    return Present(shapes);
  }
  /// The signals to log.
  static std::vector<const Source*> Signals(const QuadrupedWalk& loop);
  /// The diagnostics of the whole-body controller; null if a controller without them replaced it. They hold
  /// wall-clock times, so they are not in Signals, whose log must be the same in each run.
  static const OutputPort<WholeBodyDiagnostics>* Solves(const QuadrupedWalk& loop) {
    return FindCurrent(loop.locomotion.whole_body.diagnostics);
  }
  /// The diagnostics of the predictive controller, with wall-clock times too; null without one.
  static const OutputPort<CentroidalMpcDiagnostics>* MpcSolves(const QuadrupedWalk& loop) {
    return loop.locomotion.mpc ? FindCurrent(loop.locomotion.mpc->diagnostics) : nullptr;
  }
  /// The signals that must be logged for the figures: Signals with WithSolvers.
  static std::vector<const Source*> Judged(const QuadrupedWalk& loop) {
    return WithSolvers(Signals(loop), loop);
  }
  /// `signals` and what the figures need of parts that not every walk has: the wrench of bodies that were
  /// added to the plant, the estimate of the state and its errors.
  static std::vector<const Source*> WithOptions(std::vector<const Source*> signals,
                                                const QuadrupedWalk& loop);
  /// `signals`, the diagnostics of the solvers that the loop has, and the commanded walk.
  static std::vector<const Source*> WithSolvers(std::vector<const Source*> signals,
                                                const QuadrupedWalk& loop);

  /// Figures are computed from `from` [s] on; `path` is judged from the start. Without an observer
  /// (`observes` is false) there are no figures of its estimate.
  WalkFigures(const QuadrupedWalk& loop, double from, bool observes, const PathVerdict& path);
  void Begin(const std::vector<std::string>& names, const std::vector<std::string>&) override;
  void Row(std::span<const double> row) override;
  void AddTo(Summary& summary) const;
  /// Straight-line distance that the commanded velocities cover from `from` to the end of the run [m].
  double commanded() const { return commanded_.norm(); }

 private:
  struct Sample {
    double time, error;
  };
  struct LegFigures {
    bool stance = false;
    double touchdown = 0;        // [s]
    std::deque<Sample> waiting;  // errors of the last kEdge seconds, dropped at lift-off
    std::array<double, 3> slip{};
    Tally slips, errors;  // [m]
  };

  void LegRow(std::span<const double> row, std::size_t leg, const WalkingErrors& errors);
  void JointRow(double time, const Vec<12>& torque, const Vec<12>& speed);

  const QuadrupedWalk& loop_;
  double from_;
  bool observes_;
  PathVerdict path_;
  Logged<WrenchEstimate> external_, added_, estimated_, ropes_;
  Logged<WalkingErrors> errors_;
  Logged<PlanarPath> commanded_path_;  // of a planner that resets its reference
  Logged<LeggedState> state_;
  Logged<BodyReference> body_;
  Logged<WalkCommand> command_;
  Logged<Vec<12>> torque_;
  std::vector<std::size_t> slip_, touch_;
  std::array<std::size_t, kNumLegs> contact_{};

  std::array<LegFigures, kNumLegs> legs_;
  std::optional<Terrain> terrain_;                // the ground of the plant, if it is known
  Tally climb_, flight_;                          // [m], 1 while no foot touches the ground
  Vec<2> commanded_ = Vec<2>::Zero();             // in the commanded heading at `from_` [m]
  double commanded_yaw_ = 0;                      // [rad]
  double time_ = 0;                               // [s]
  double work_ = 0;                               // [J]
  std::optional<Vec<12>> last_torque_;            // [N m]
  Tally torque_rates_;                            // [N m/s]
  Tally com_errors_, force_errors_;               // [m], [N]
  std::array<Tally, 3> estimates_;                // [N]
  Tally estimate_errors_;                         // [N]
  std::optional<std::array<double, 2>> begin_{};  // horizontal position of the trunk [m]
  std::array<double, 2> end_{};
  SolveFigures qp_, mpc_;
  EstimateFigures estimate_;
};

}  // namespace tenon::apps
