#pragma once

#include <tenon/systems/framework/types/signal.h>

namespace tenon {

/// Force and torque on a point of a robot, given in W.
struct PointForce {
  int body;                          ///< 0 the trunk or platform, 1 + j the body that joint j moves
  Vec<3> p_W;                        ///< [m]
  Vec<3> force_W;                    ///< [N]
  Vec<3> torque_W = Vec<3>::Zero();  ///< [N m]
};

}  // namespace tenon
