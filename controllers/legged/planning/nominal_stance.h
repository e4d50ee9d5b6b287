#pragma once

#include <tenon/plants/model/quadruped_description.h>

namespace tenon {

/// Geometry of a robot in its nominal stance, which the planners move along the path: the point of the path
/// is the centre of the four feet, and its heading is the trunk's x.
struct NominalStance {
  explicit NominalStance(const QuadrupedDescription& robot);

  Eigen::Vector2d center_B;                    ///< centre of the feet [m]
  std::array<Eigen::Vector2d, kNumLegs> foot;  ///< positions of the feet from their centre [m]
  Eigen::Vector3d com_B;                       ///< [m]
  Eigen::Matrix3d inertia_B;                   ///< about the CoM, joints locked [kg m^2]
  double com_height;                           ///< height of the CoM above level ground [m]
  std::array<double, kNumLegs>
      longest;  ///< longest distance from hip to foot with a bent knee, within its range [m]
  std::array<double, kNumLegs> reach;  ///< largest horizontal distance of a foothold from `foot` [m]
};

}  // namespace tenon
