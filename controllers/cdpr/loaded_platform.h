#pragma once

#include <tenon/plants/model/cdpr_description.h>
#include <tenon/plants/signals/cdpr_signals.h>

namespace tenon {

/// A platform with a point mass as one rigid body C. Its origin is the common CoM, its axes are those of B:
///
///     m = m_B + m_L,   c = m_L r / m,
///     I = I_B + m_B (|c|^2 1 - c c^T) + m_L (|r - c|^2 1 - (r - c)(r - c)^T)
struct LoadedPlatform {
  double mass = 0;                                    ///< m [kg]
  Eigen::Vector3d com_B = Eigen::Vector3d::Zero();    ///< c, from the platform's own CoM [m]
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  ///< about c, in B's axes [kg m^2]

  LoadedPlatform(const CdprDescription& robot, const Payload& payload);
};

}  // namespace tenon
