#pragma once

#include <tenon/apps/common/columns.h>
#include <tenon/apps/common/verdicts.h>
#include <tenon/diagrams/legged/quadruped_stand.h>
#include <tenon/plants/legged/quadruped_clearance.h>

namespace tenon::apps {

/// The parameters of the plant that stands in the diagram, see CurrentAs.
inline const QuadrupedPlantParams& ParamsOf(const QuadrupedPlant& plant) {
  return CurrentAs<LeafSystem<QuadrupedPlantParams>>(plant).params;
}

/// Limits of torque and speed of each joint [N m, rad/s], in both directions; none if they are unknown.
std::vector<SignalLimits> DriveLimits(const QuadrupedPlant& plant);

/// The clearances of the robot that stands in the diagram.
QuadrupedClearance MakeClearance(const QuadrupedPlant& plant);

/// Checks the physical limits of drives, feet, legs, trunk and ground, from a log of every control tick.
///
/// The torque of a drive must stay within its torque-speed line at the joint's speed, whether or not the
/// plant enforced this. A joint that is driven beyond its speed limit from outside is no breach while its
/// drive stays within the line. Links and trunk must not penetrate each other or the ground by more than
/// `kPressedIn`, and a foot must not penetrate the ground by more than `kPressedRatio` of its radius, or
/// kPressedIn if that is more. Neither must the shapes of bodies that were added to the robot enter the
/// ground by more than kPressedIn. The limits of a plant with other parameters than QuadrupedPlantParams are
/// unknown, and nothing is checked.
class LimitFigures final : public LogSink {
 public:
  static constexpr double kPressedIn = 0.005;   ///< penetration of links and trunk [m]
  static constexpr double kPressedRatio = 0.5;  ///< penetration of a foot, relative to its radius

  /// The signals that must be logged.
  static std::vector<const Source*> Signals(const QuadrupedPlant& plant);

  explicit LimitFigures(const QuadrupedPlant& plant);
  void Begin(const std::vector<std::string>& names, const std::vector<std::string>&) override;
  void Row(std::span<const double> row) override;
  /// Adds the figures with their limits, and the breaches.
  void AddTo(Summary& summary) const;

 private:
  void DriveRow(double time, const Vec<12>& torques, const Vec<12>& speeds);
  void FootRow(double time, const Vec<4>& depths);
  void ClearanceRow(double time, const LeggedState& x);

  const QuadrupedPlant& plant_;
  bool known_;  // whether the limits of the plant in the diagram are known
  QuadrupedDescription robot_;
  QuadrupedClearance clearance_;
  Terrain terrain_;
  AddedShapes added_;
  double foot_limit_;  // [m]
  Logged<LeggedState> state_;
  Logged<Vec<12>> torque_;
  Logged<Vec<4>> depth_;

  Tally torques_, speeds_, excesses_, depths_;   // [N m], [rad/s], [N m], [m]
  Tally legs_, trunk_, ground_, added_heights_;  // [m]
  Breaches breaches_;
};

/// Figures of a standing robot, computed during the run from a log of Signals.
class StandFigures final : public LogSink {
 public:
  /// The signals that must be logged.
  static std::vector<const Source*> Signals(const QuadrupedStand& loop);
  static std::vector<const Source*> Judged(const QuadrupedStand& loop) { return Signals(loop); }
  /// The shapes of a replay.
  static std::vector<const OutputPort<Geometry>*> Shapes(const QuadrupedStand& loop) {
    std::vector<const OutputPort<Geometry>*> shapes{&loop.world.plant.geometry};
    if (const SlidingLoad* load = loop.world.sliding_load) shapes.push_back(&load->geometry);
    return Present(shapes);
  }

  explicit StandFigures(const QuadrupedStand& loop) : world_(loop.world) {}
  void Begin(const std::vector<std::string>& names, const std::vector<std::string>&) override;
  void Row(std::span<const double> row) override;

  void AddTo(Summary& summary) const;

 private:
  const QuadrupedWorld& world_;
  Logged<LeggedState> state_;
  std::vector<std::size_t> force_;
  std::optional<Vec<2>> start_;               // horizontal position of the trunk [m]
  Tally height_, tilt_;                       // height and tilt of the trunk [m], [rad]
  Tally load_;                                // magnitude of the force on a foot [N]
  std::optional<double> height_end_, drift_;  // [m]
};

}  // namespace tenon::apps
