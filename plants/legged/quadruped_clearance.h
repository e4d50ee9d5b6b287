#pragma once

#include <tenon/plants/model/quadruped_description.h>
#include <tenon/plants/signals/legged_signals.h>
#include <tenon/plants/surroundings/terrain.h>

namespace tenon {

/// Distances between parts of a quadruped and to the ground; negative if they overlap.
struct QuadrupedClearances {
  struct Gap {
    double distance = std::numeric_limits<double>::infinity();  ///< between surfaces [m]
    int leg = -1;                                               ///< nearest leg, see Leg; -1: the trunk
    int other = -1;                                             ///< second leg; -1: none
  };
  Gap legs;    ///< between two legs
  Gap trunk;   ///< between a leg and the trunk
  Gap ground;  ///< between trunk, hips or knees and the ground
};

/// Computes clearances of a quadruped by simple shapes; QuadrupedPlant has no forces that prevent their
/// overlap.
///
/// Links are capsules as in MakeQuadrupedGeometry, from joint to joint and to the foot. For the ground and
/// for other bodies, the trunk consists of QuadrupedDescription::trunk_shapes, or without them of
/// BoxBetweenHips. For the legs it is BoxBetweenHips, since their capsules do not follow the housings at the
/// hips; a thigh whose joint is nearer to the axis of the abduction than a link is thick, so within the hip's
/// housing, begins there without its round end. Pairs that overlap in the nominal stance are excluded, since
/// they are adjacent or approximated too coarsely. Only the ends of the links, without the feet, are compared
/// with the ground: the middle of a shank may cut the edge of a box unnoticed.
class QuadrupedClearance {
 public:
  QuadrupedClearance(const QuadrupedDescription& robot, const TerrainParams& terrain);

  /// The clearances at x. Does not allocate.
  QuadrupedClearances At(const LeggedState& x) const;

  /// The distance between a robot with the joint angles q and the segment [p, p + u] in B, with the nearest
  /// leg or -1 for the trunk; 0 if the segment reaches into the trunk, whose boxes are reduced by `less` on
  /// all sides.
  QuadrupedClearances::Gap To(const Vec<kNumJoints>& q, const Eigen::Vector3d& p_B,
                              const Eigen::Vector3d& u_B, double less = 0) const;
  /// The point p in B, lifted just above a box of the trunk if it lies inside.
  Eigen::Vector3d OnTrunk(const Eigen::Vector3d& p_B) const;
  /// The largest distance of any part of the robot from B's origin [m].
  double reach() const { return reach_; }

 private:
  /// Origins of the joints of each leg, and centre of its foot, in B [m].
  using Points = std::array<std::array<Eigen::Vector3d, kJointsPerLeg + 1>, kNumLegs>;
  struct Link {
    std::size_t leg, index;
  };

  Points PointsAt(const Vec<kNumJoints>& q) const;
  double Distance(const Points& points, Link a, Link b) const;
  double TrunkDistance(const Points& points, Link link) const;
  QuadrupedClearances::Gap Ground(const LeggedState& x, const Points& points) const;

  QuadrupedDescription robot_;
  Terrain terrain_;
  double radius_;     // of the links [m]
  double reach_ = 0;  // [m]
  RoundedBox between_hips_;
  std::vector<RoundedBox> trunk_;
  std::array<std::array<double, kJointsPerLeg>, kNumLegs> half_lengths_;  // of the links [m]
  std::vector<std::pair<Link, Link>> pairs_;
  std::vector<Link> beside_trunk_;
};

}  // namespace tenon
