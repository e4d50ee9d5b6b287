#pragma once

#include <tenon/plants/signals/legged_signals.h>
#include <tenon/systems/block.h>
#include <tenon/systems/geometry.h>

namespace tenon {

/// A cylindrical obstacle, such as a pillar.
struct Obstacle {
  Vec<2> centre = Vec<2>::Zero();         ///< centre of the pillar in W [m]
  double radius = 0;                      ///< radius of the pillar [m]
  static constexpr double kHeight = 0.8;  ///< height of every pillar [m]

  static FieldList Fields() {
    return {Required("centre_m", &Obstacle::centre).Finite(),
            Required("radius_m", &Obstacle::radius).Positive()};
  }
};

struct ObstacleDetectorParams {
  std::vector<Obstacle> obstacles;
  double range = 1.2;       ///< detection range ahead of B's origin [m]
  double half_width = 0.4;  ///< half width of the monitored strip ahead of the robot [m]
  double margin = 0.05;     ///< distance beyond the range to which a seen obstacle stays in sight [m]
  Rate rate = Hz(100);      ///< rate of in_sight

  static FieldList Fields() {
    return {{"obstacles", &ObstacleDetectorParams::obstacles},
            Field("range_m", &ObstacleDetectorParams::range).Positive(),
            Field("half_width_m", &ObstacleDetectorParams::half_width).AtLeast(0),
            Field("margin_m", &ObstacleDetectorParams::margin).AtLeast(0),
            Undescribed(&ObstacleDetectorParams::rate)};
  }
};

/// Detects obstacles ahead of a robot: true if a pillar's nearest point is less than `range` ahead of B's
/// origin and the pillar overlaps the strip of half_width to both sides of the heading. It models an ideal
/// vision sensor. `in_sight` has a hysteresis, since a standing robot sways: once true, it stays true up to
/// `margin` beyond the range. The pillars exert no forces; tenon-guide-dog reports collisions.
class ObstacleDetector final : public LeafSystem<ObstacleDetectorParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPort<LeggedState> state{this, {"state"}};
  Parameter<double> range{this, {"range", "m"}, params.range, "detection range ahead of B's origin"};
  Parameter<double> half_width{this, {"half_width", "m"}, params.half_width, "half width of the strip ahead"};
  OutputPort<bool> obstacle{
      this, {"obstacle"}, Uses(state, range, half_width), &ObstacleDetector::CalcObstacle};
  Scratch<bool> saw{this, "saw", false};
  OutputPort<bool> in_sight{this,
                            {"in_sight"},
                            Sampled{params.rate},
                            Uses(state, range, half_width, saw),
                            &ObstacleDetector::CalcInSight};
  OutputPort<Geometry> geometry{this, {"geometry"}, MakeGeometry(params), Uses(), [](Geometry*) {}};

 private:
  bool CalcObstacle(const LeggedState& state, double range, double half_width) const;
  bool CalcInSight(const LeggedState& state, double range, double half_width, bool& saw) const {
    return saw = CalcObstacle(state, saw ? range + params.margin : range, half_width);
  }
  static Geometry MakeGeometry(const ObstacleDetectorParams& params);
};

}  // namespace tenon
