#pragma once

#include <tenon/plants/model/quadruped_description.h>

#include <Eigen/Core>

#include <array>

namespace tenon {

/// Where feet and CoM are when a robot stands in its nominal stance. The planners walk it along the path: the
/// path's point is the centre of the four feet, its heading is the trunk's x.
struct NominalStance {
  explicit NominalStance(const QuadrupedDescription& robot);

  Eigen::Vector2d center_B;                    ///< of the feet [m]
  std::array<Eigen::Vector2d, kNumLegs> foot;  ///< from the centre of the feet [m]
  Eigen::Vector3d com_B;                       ///< [m]
  Eigen::Matrix3d inertia_B;                   ///< about the CoM, joints locked [kg m^2]
  double com_height;                           ///< above level ground [m]
  std::array<double, kNumLegs> longest;        ///< from hip to foot, with the knee still bent [m]
  std::array<double, kNumLegs> reach;          ///< how far a foot on the ground goes from there [m]
};

}  // namespace tenon
