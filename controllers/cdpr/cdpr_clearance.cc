#include <tenon/controllers/cdpr/cdpr_clearance.h>
#include <tenon/plants/model/vectors.h>

namespace tenon {

CdprClearance::CdprClearance(const CdprDescription& robot, std::optional<double> from_obstacles,
                             std::optional<double> between_cables, const CableKinematics& start)
    : from_obstacles_(from_obstacles.value_or(0)),
      between_cables_(between_cables.value_or(0)),
      box_(PlatformBox(robot)) {
  constexpr double kTogether = 1e-6;  // distance below which two points coincide [m]
  if (from_obstacles) obstacles_ = robot.obstacles;
  for (const CableDescription& cable : robot.cables) attachments_B_.push_back(cable.attachment_B);
  const auto span = [&](int i) {
    const Eigen::Vector3d exit_W = start.exit_W.col(i);
    return Span{exit_W, exit_W - start.free_length[i] * start.direction.col(i)};
  };
  for (int i = 0; between_cables && i < robot.num_cables(); ++i)
    for (int j = 0; j < i; ++j)
      if (Between(span(j), span(i), 0).value >= std::max(between_cables_, kTogether))
        pairs_.emplace_back(j, i);
  size_ = static_cast<int>(obstacles_.size() * (1 + attachments_B_.size()) + pairs_.size());
}

PoseDistance CdprClearance::Between(const Span& a, const Span& b, double kept, bool b_moves) {
  const Eigen::Vector3d u = a.to_W - a.from_W, v = b.to_W - b.from_W;
  Eigen::Vector2d at;
  const double distance = SegmentDistance(a.from_W, u, b.from_W, v, &at);
  const Eigen::Vector3d normal_W = (a.from_W + at[0] * u - b.from_W - at[1] * v).normalized();
  if (!b_moves) at[1] = 0;
  return {distance, kept, (at[0] - at[1]) * normal_W, (at[0] * a.arm_W - at[1] * b.arm_W).cross(normal_W)};
}

PoseDistance CdprClearance::FromCable(const Span& cable, const ObstacleDescription& obstacle) const {
  PoseDistance distance = Between(cable, {obstacle.from_W, obstacle.to_W}, from_obstacles_, false);
  distance.value -= obstacle.radius;
  return distance;
}

PoseDistance CdprClearance::FromPlatform(const Eigen::Vector3d& p_WB, const Eigen::Matrix3d& R_WB,
                                         const ObstacleDescription& obstacle) const {
  const Eigen::Vector3d from_B = R_WB.transpose() * (obstacle.from_W - p_WB);
  const Eigen::Vector3d axis_B = R_WB.transpose() * (obstacle.to_W - obstacle.from_W);
  double at = 0;
  const double distance = SegmentBoxDistance(from_B, axis_B, box_, &at);
  const Eigen::Vector3d other_B = from_B + at * axis_B, nearest_B = other_B.cwiseMax(-box_).cwiseMin(box_);
  const Eigen::Vector3d normal_B = (nearest_B - other_B).normalized();
  return {distance - obstacle.radius, from_obstacles_, R_WB * normal_B, R_WB * nearest_B.cross(normal_B)};
}

}  // namespace tenon
