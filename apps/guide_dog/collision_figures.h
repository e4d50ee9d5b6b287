#pragma once

#include <tenon/apps/common/verdicts.h>
#include <tenon/diagrams/guide_dog/guide_dog.h>
#include <tenon/plants/legged/quadruped_clearance.h>

namespace tenon::apps {

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
  std::vector<std::size_t> position_, attitude_, q_, person_, hand_;
  Tally to_person_, to_obstacles_;  // [m]
  Breaches breaches_;
};

}  // namespace tenon::apps
