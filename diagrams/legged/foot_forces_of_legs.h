#pragma once

#include <tenon/controllers/legged/observers/ground_force_observer.h>
#include <tenon/controllers/legged/observers/leg_momentum_observer.h>
#include <tenon/systems/framework/diagram/diagram_builder.h>

namespace tenon {

struct FootForcesOfLegsParams {
  QuadrupedDescription robot;  ///< model of the robot
  LeggedState initial = {};    ///< state before the first tick
  ContactThresholds thresholds = {};
  LegObserverGains gains{.gains = {300, 768}, .butterworth = {}};  ///< settle within about 8 ms
  Rate rate = Hz(1000);
};

/// Estimates the ground forces on the feet of a robot without foot sensors, from the joint torques.
///
///     state, torque, ground ──► legs ──► ground_forces ──► forces
///
/// All inputs are delayed by one tick, because the gait schedule, on which they depend, reads this estimate.
class FootForcesOfLegs final : public Subdiagram {
 public:
  explicit FootForcesOfLegs(const FootForcesOfLegsParams& params);

  InputPort<LeggedState> state{this, {"state"}};
  InputPort<Vec<12>> torque{this, {"torque", "N m"}};
  InputPort<GroundPlane> ground{this, {"ground"}, GroundPlane()};

  LegMomentumObserver& legs;
  GroundForceObserver& ground_forces;

  OutputPort<FootForces> forces{this, {"forces"}};
};

}  // namespace tenon
