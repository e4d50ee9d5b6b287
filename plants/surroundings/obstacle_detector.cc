#include <tenon/plants/surroundings/obstacle_detector.h>

namespace tenon {

bool ObstacleDetector::CalcObstacle(const LeggedState& state, double range, double half_width) const {
  const Eigen::Vector2d heading = state.R_WB().col(0).head<2>().normalized();
  for (const Obstacle& obstacle : params.obstacles) {
    const Eigen::Vector2d to = obstacle.centre - state.p_WB.head<2>();
    const double ahead = heading.dot(to), aside = heading[0] * to[1] - heading[1] * to[0];
    if (ahead > 0 && ahead - obstacle.radius < range && std::abs(aside) < half_width + obstacle.radius)
      return true;
  }
  return false;
}

bool ObstacleDetector::CalcInSight(const LeggedState& state, double range, double half_width,
                                   bool& saw) const {
  return saw = CalcObstacle(state, saw ? range + params.margin : range, half_width);
}

Geometry ObstacleDetector::MakeGeometry(const ObstacleDetectorParams& params) {
  Geometry shapes;
  for (std::size_t i = 0; i < params.obstacles.size(); ++i) {
    const Obstacle& obstacle = params.obstacles[i];
    shapes.push_back(Shape::Cylinder(ShapeRole::kFixture, "obstacle " + std::to_string(i), obstacle.radius,
                                     Obstacle::kHeight));
    shapes.back().p_W << obstacle.centre, Obstacle::kHeight / 2;
  }
  return shapes;
}

}  // namespace tenon
