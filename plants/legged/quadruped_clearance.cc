#include <tenon/plants/legged/quadruped_clearance.h>
#include <tenon/plants/legged/quadruped_geometry.h>
#include <tenon/plants/model/vectors.h>

#include <algorithm>

namespace tenon {

static constexpr double kRounding = 1e-9;  // [m], above rounding errors
static constexpr double kAbove = 1e-3;     // [m]

QuadrupedClearance::QuadrupedClearance(const QuadrupedDescription& robot, const TerrainParams& terrain)
    : robot_(robot),
      terrain_(terrain),
      radius_(LinkRadius(robot)),
      between_hips_(BoxBetweenHips(robot)),
      trunk_(robot.trunk_shapes) {
  if (trunk_.empty()) trunk_ = {between_hips_};
  const Points stance = PointsAt(robot.stance);
  for (const RoundedBox& box : trunk_)
    reach_ = std::max(reach_, box.p_B.norm() + box.half.norm() + box.radius);
  for (std::size_t leg = 0; leg < kNumLegs; ++leg) {
    double reach = stance[leg][0].norm() + radius_;
    for (std::size_t i = 0; i < kJointsPerLeg; ++i) {
      half_lengths_[leg][i] = (stance[leg][i + 1] - stance[leg][i]).norm() / 2;
      reach += 2 * half_lengths_[leg][i];
    }
    reach_ = std::max(reach_, reach);
  }
  for (std::size_t leg = 0; leg < kNumLegs; ++leg) {
    for (std::size_t i = 0; i < kJointsPerLeg; ++i) {
      for (std::size_t other = leg + 1; other < kNumLegs; ++other)
        for (std::size_t j = 0; j < kJointsPerLeg; ++j)
          if (Distance(stance, {leg, i}, {other, j}) > 0) pairs_.push_back({{leg, i}, {other, j}});
      if (i > 0 && TrunkDistance(stance, {leg, i}) > 0) beside_trunk_.push_back({leg, i});
    }
  }
}

QuadrupedClearance::Points QuadrupedClearance::PointsAt(const Vec<kNumJoints>& q) const {
  Points points;
  for (std::size_t leg = 0; leg < kNumLegs; ++leg) {
    const LegPose pose = robot_.PoseOfLeg(static_cast<int>(leg), q);
    std::copy(pose.p_BJ.begin(), pose.p_BJ.end(), points[leg].begin());
    points[leg][kJointsPerLeg] = pose.foot_B;
  }
  return points;
}

double QuadrupedClearance::Distance(const Points& points, Link a, Link b) const {
  const auto& p = points[a.leg];
  const auto& q = points[b.leg];
  return SegmentDistance(p[a.index], p[a.index + 1] - p[a.index], q[b.index], q[b.index + 1] - q[b.index]) -
         2 * radius_;
}

/// The distance of the segment [p, p + u] from a box that is reduced by `less` on all sides.
static double BoxDistance(const Eigen::Vector3d& p_B, const Eigen::Vector3d& u_B, const RoundedBox& box,
                          double less = 0) {
  const Eigen::Matrix3d R_SB = box.R_BS.transpose();
  const Eigen::Vector3d half = (box.half.array() - less).max(0);
  return SegmentBoxDistance(R_SB * (p_B - box.p_B), R_SB * u_B, half) - box.radius;
}

double QuadrupedClearance::TrunkDistance(const Points& points, Link link) const {
  const auto& joints = robot_.legs[link.leg].joints;
  const Eigen::Vector3d& end = points[link.leg][link.index + 1];
  Eigen::Vector3d begin = points[link.leg][link.index];
  if (link.index == 1 && joints[1].p_PJ.cross(joints[0].axis).norm() < 2 * radius_)
    begin += std::min(1.0, radius_ / joints[2].p_PJ.norm()) * (end - begin);
  return BoxDistance(begin, end - begin, between_hips_) - radius_;
}

QuadrupedClearances::Gap QuadrupedClearance::Ground(const LeggedState& x, const Points& points) const {
  QuadrupedClearances::Gap least;
  const Eigen::Matrix3d R_WB = x.R_WB();
  const auto add = [&](const Eigen::Vector3d& p_B, double radius, int leg) {
    const Eigen::Vector3d p_W = x.p_WB + R_WB * p_B;
    const Terrain::Surface ground = terrain_.At(p_W[0], p_W[1]);
    const double distance = (p_W[2] - ground.height) * ground.normal_W[2] - radius;
    if (distance < least.distance) least = {distance, leg};
  };
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d sides((corner & 1) == 0 ? -1 : 1, (corner & 2) == 0 ? -1 : 1,
                                (corner & 4) == 0 ? -1 : 1);
    for (const RoundedBox& box : trunk_)
      add(box.p_B + box.R_BS * box.half.cwiseProduct(sides), box.radius, -1);
  }
  for (std::size_t leg = 0; leg < kNumLegs; ++leg)
    for (std::size_t i = 1; i < kJointsPerLeg; ++i) add(points[leg][i], radius_, static_cast<int>(leg));
  return least;
}

QuadrupedClearances QuadrupedClearance::At(const LeggedState& x) const {
  const Points points = PointsAt(x.q);
  QuadrupedClearances clear;
  // Skips pairs whose midpoints are too far apart to be the nearest.
  const auto middle = [&](Link link) -> Eigen::Vector3d {
    return (points[link.leg][link.index] + points[link.leg][link.index + 1]) / 2;
  };
  const auto reach = [&](Link link) { return half_lengths_[link.leg][link.index] + radius_ + kRounding; };
  const auto is_beyond = [](const Eigen::Vector3d& way, double most) {
    return way.squaredNorm() > most * most || most < 0;
  };
  for (const auto& [a, b] : pairs_) {
    if (is_beyond(middle(a) - middle(b), clear.legs.distance + reach(a) + reach(b))) continue;
    const double distance = Distance(points, a, b);
    if (distance < clear.legs.distance)
      clear.legs = {distance, static_cast<int>(a.leg), static_cast<int>(b.leg)};
  }
  for (const Link& link : beside_trunk_) {
    const Eigen::Vector3d &half = between_hips_.half, p = middle(link) - between_hips_.p_B;
    const Eigen::Vector3d way = p - p.cwiseMax(-half).cwiseMin(half);
    if (is_beyond(way, clear.trunk.distance + reach(link))) continue;
    const double distance = TrunkDistance(points, link);
    if (distance < clear.trunk.distance) clear.trunk = {distance, static_cast<int>(link.leg)};
  }
  clear.ground = Ground(x, points);
  return clear;
}

QuadrupedClearances::Gap QuadrupedClearance::To(const Vec<kNumJoints>& q, const Eigen::Vector3d& p_B,
                                                const Eigen::Vector3d& u_B, double less) const {
  QuadrupedClearances::Gap gap;
  for (const RoundedBox& box : trunk_)
    gap.distance = std::min(gap.distance, std::max(0.0, BoxDistance(p_B, u_B, box, less)));
  const Points points = PointsAt(q);
  for (std::size_t leg = 0; leg < kNumLegs; ++leg) {
    for (std::size_t i = 0; i < kJointsPerLeg; ++i) {
      const Eigen::Vector3d& from = points[leg][i];
      const double distance = SegmentDistance(from, points[leg][i + 1] - from, p_B, u_B) - radius_;
      if (distance < gap.distance) gap = {distance, static_cast<int>(leg)};
    }
  }
  return gap;
}

Eigen::Vector3d QuadrupedClearance::OnTrunk(const Eigen::Vector3d& p_B) const {
  Eigen::Vector3d p = p_B;
  for (const RoundedBox& box : trunk_)
    if (BoxDistance(p_B, Eigen::Vector3d::Zero(), box) <= 0)
      p[2] = std::max(p[2], box.p_B[2] + box.R_BS.row(2).cwiseAbs() * box.half + box.radius + kAbove);
  return p;
}

}  // namespace tenon
