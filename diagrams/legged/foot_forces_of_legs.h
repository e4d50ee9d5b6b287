#pragma once

#include <tenon/controllers/legged/observers/ground_force_observer.h>
#include <tenon/controllers/legged/observers/leg_momentum_observer.h>
#include <tenon/systems/framework/diagram/diagram_builder.h>

namespace tenon {

struct FootForcesOfLegsParams {
  QuadrupedDescription robot;  ///< what the robot believes
  LeggedState initial = {};    ///< until the first estimate
  ContactThresholds thresholds = {};
  LegObserverGains gains{.gains = {300, 768}, .butterworth = {}};  ///< settles within some 8 ms
  Rate rate = Hz(1000);
};

/// What a robot without sensors in its feet knows of the forces on them, from the torques of its joints.
///
///     state, torque, ground ──► legs ──► ground_forces ──► forces
///
/// All inputs are taken as they were a tick ago: the estimate of this tick depends on which feet stand.
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
