#pragma once

#include <tenon/plants/model/quadruped_description.h>
#include <tenon/plants/signals/legged_signals.h>
#include <tenon/plants/surroundings/terrain.h>

#include <array>
#include <limits>
#include <vector>

namespace tenon {

/// How far the parts of a quadruped are from one another and from the ground; below 0 they meet.
struct QuadrupedClearances {
  struct Gap {
    double distance = std::numeric_limits<double>::infinity();  ///< between surfaces [m]
    int leg = -1;    ///< the leg that is nearest, see Leg; -1: the trunk
    int other = -1;  ///< the leg that it is nearest to, if it is one
  };
  Gap legs;    ///< of two legs
  Gap trunk;   ///< of a leg and the trunk
  Gap ground;  ///< of trunk, hips or knees and the ground below
};

/// The bodies of a quadruped as shapes that must not meet, which no force of QuadrupedPlant prevents.
///
/// Links are capsules as in MakeQuadrupedGeometry, from joint to joint and to the foot. The trunk is the box
/// that the first joints of the legs span, as high as the uniform box with its mass and moments of inertia.
/// What meets in the nominal stance is joined there, or the shapes are too coarse for it: it is left out.
/// A URDF's own collision geometry is not read. Of the links the ends alone are held against the ground,
/// without the feet, whose contact is the plant's: a shank beside a box may go through its edge.
class QuadrupedClearance {
 public:
  QuadrupedClearance(const QuadrupedDescription& robot, const TerrainParams& terrain);

  /// Allocates nothing.
  QuadrupedClearances At(const LeggedState& x) const;

 private:
  /// The hip, the knee and the foot of each leg between the origins of its joints, in B.
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
  double radius_;                  // of the links [m]
  Eigen::Vector3d middle_, half_;  // of the trunk's box, and half its edges, in B [m]
  std::array<std::array<double, kJointsPerLeg>, kNumLegs> half_lengths_;  // of the links [m]
  std::vector<std::pair<Link, Link>> pairs_;
  std::vector<Link> beside_trunk_;
};

}  // namespace tenon
