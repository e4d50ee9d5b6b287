#pragma once

#include <tenon/apps/common/columns.h>
#include <tenon/apps/guide_dog/guide_dog_scenario.h>
#include <tenon/plants/legged/quadruped_clearance.h>

namespace tenon::apps {

/// Figures of a person on a leash, computed during the run from a log of every control tick. Tension and
/// length of the leash are the true ones.
///
/// Mean tension and distance are taken while the robot walks as commanded and the person follows, starting
/// when the tension first reaches the desired one after each start. The figures of `walking`, and the share
/// of that time in which the leash is slack, begin at the start itself. The delay of the stop is the time
/// from the first cause, a tension above the threshold or an obstacle, until the trunk has been slower than
/// `kStanding` for half a second. The heading error is that of the mean heading in the last second of the
/// run, relative to the direction in which the leash pulled the robot at its last start.
class GuideDogFigures final : public LogSink {
 public:
  static constexpr double kStanding = 0.02;  ///< [m/s]

  /// The signals to log.
  static std::vector<const Source*> Signals(const GuideDog& loop);
  /// The signals for these figures and WalkFigures: Signals and the diagnostics of the whole-body controller,
  /// see WalkFigures::Judged.
  static std::vector<const Source*> Judged(const GuideDog& loop);
  /// The shapes of a replay.
  static std::vector<const OutputPort<Geometry>*> Shapes(const GuideDog& loop);

  /// The parameters of the loop, unlike those of its scenario, are scaled to the robot. Without a task, as in
  /// a live run, nothing is judged. With one, the leash must tighten by the end of the person's first phase
  /// of following; a person who stops at the end of her phases must stop the robot; and the robot must take
  /// the direction of her last pull by the end of that phase, walk that way, and be on it at the end.
  explicit GuideDogFigures(const GuideDog& loop, const std::optional<GuideDogTask>& task = {});
  void Begin(const std::vector<std::string>& names, const std::vector<std::string>&) override;
  void Row(std::span<const double> row) override;
  void AddTo(Summary& summary) const;

 private:
  void LeashRow(std::span<const double> row, const LeashState& leash);
  void StopRow(std::span<const double> row, double tension, const Vec<3>& v_W);
  void HeadingRow(std::span<const double> row, const Vec<3>& direction_W, const Eigen::Matrix3d& R);
  /// Mean heading of the last second, relative to the pull [deg]; empty without a pull.
  std::optional<double> HeadingError() const;

  const GuideDog& loop_;
  std::optional<GuideDogTask> task_;
  double desired_tension_, threshold_;  // [N]

  Logged<LeashState> leash_;
  Logged<LeggedState> state_;
  std::size_t obstacle_ = 0;
  std::optional<std::size_t> mode_, activity_, speed_;

  bool leads_ = false;
  Tally tensions_, tensions_leading_, tensions_walking_;  // [N]
  Tally distances_leading_, distances_walking_, slack_;   // [m], [m], 1 while slack
  std::optional<double> cause_, standing_, stop_delay_;   // [s]
  std::optional<double> pull_yaw_;                        // [rad]
  double last_mode_ = 0;
  std::optional<double> moves_since_;  // [s]
  double time_ = 0;                    // [s]
  std::deque<Vec<2>> headings_;        // headings of the last second as unit vectors
  Condition tightens_{"leash_tight_at_s", "the leash never tightened"};
  Condition crosses_{"crossing_at_s", "the leash never reached the tension that stops the robot"};
  Condition directed_{"direction_given_at_s", "the person never gave a direction"};
  Condition restarts_{"restart_at_s", "the robot did not walk along the pull"};
};

/// Checks that robot, person, leash and pillars do not run through each other, from a log of every control
/// tick. None of them exerts contact forces on another.
///
/// The robot has the shapes of QuadrupedClearance, the person and the pillars those that are drawn. Any
/// overlap of them is a breach that names both. The leash is the straight line from hand to trunk, slack or
/// taut; it must not run through a pillar, a leg, or the trunk without its outer `kSoft`, over which a leash
/// can bend. An attachment inside the trunk's box counts as one on top of it. The person holds the leash at
/// an axis inside the body, so these two are not compared.
class CollisionFigures final : public LogSink {
 public:
  static constexpr double kSoft = 0.05;  ///< outer part of the trunk's box that the leash may touch [m]

  /// The signals that must be logged.
  static std::vector<const Source*> Signals(const GuideDog& loop);

  explicit CollisionFigures(const GuideDog& loop);
  void Begin(const std::vector<std::string>& names, const std::vector<std::string>&) override;
  void Row(std::span<const double> row) override;
  /// Adds the figures with their limits, and the breaches.
  void AddTo(Summary& summary) const;

 private:
  void RobotRow(double time, const LeggedState& x, const Eigen::Vector3d& place_W, double top, double radius,
                const std::string& name, Tally* distances);
  void LeashRow(double time, const LeggedState& x, const Eigen::Vector3d& hand_W);
  void Collide(double time, const std::string& one, const std::string& other, double depth);

  const GuideDog& loop_;
  bool known_;  // whether the limits of the robot are known
  QuadrupedClearance clearance_;
  std::vector<Obstacle> obstacles_;
  Vec<3> attachment_B_;             // of the leash [m]
  std::vector<std::string> names_;  // of the obstacles
  Logged<LeggedState> state_;
  Logged<PersonState> person_;
  Tally to_person_, to_obstacles_;  // [m]
  Breaches breaches_;
};

}  // namespace tenon::apps
