#pragma once

#include <tenon/controllers/joint_pd.h>
#include <tenon/plants/fall_monitor.h>
#include <tenon/plants/joint_encoders.h>
#include <tenon/plants/quadruped_plant.h>
#include <tenon/systems/diagram_builder.h>

namespace tenon {

struct QuadrupedStandParams {
  QuadrupedPlantParams plant;
  JointPdParams pd;
  JointEncodersParams encoders;
  double min_height = 0;  ///< of the trunk above the ground; below, the robot has fallen [m]
  double max_tilt = 1;    ///< of the trunk; above, the robot has fallen [rad]
};

/// A quadruped that holds its stance by joint PD,
///
///     pd ──► plant ──► encoders ──┐
///      ▲                          │
///      └──────────────────────────┘
///
/// watched by a fall monitor. The blocks are public, for logs and for taking it apart.
class QuadrupedStand final : public Subdiagram {
 public:
  explicit QuadrupedStand(const QuadrupedStandParams& params);

  JointPd& pd;
  QuadrupedPlant& plant;
  JointEncoders& encoders;

  OutputPort<LeggedState> state{this, {"state"}};
};

}  // namespace tenon
