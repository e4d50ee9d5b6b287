#pragma once

#include <tenon/plants/signals/cdpr_signals.h>
#include <tenon/systems/framework/block/ports.h>
#include <tenon/systems/framework/block/state.h>
#include <tenon/systems/framework/block/system.h>

namespace tenon {

/// Defaults: without errors.
struct WinchErrorsParams {
  int num_cables = 4;
  Rate rate = Hz(1000);           ///< of the commands
  double gain_deviation = 0;      ///< standard deviation of each winch's torque constant, over the constant
  double ripple = 0;              ///< standard deviation of the tension over the tension
  double friction = 0;            ///< mu, dry friction over tension
  double friction_speed = 0.005;  ///< v_s [m/s]

  void Validate() const;  ///< throws ParameterError
};

/// What winches make of the tension that they are asked for: their torque constants are not quite what is
/// believed, the torque ripples with the motor's angle (white from tick to tick, see DriveErrors), and gear,
/// drum and pulleys rub against the cable's motion. Of a command u at a cable whose length changes by l' > 0
/// when it is pulled out,
///
///     y = (1 + g) (1 + ripple n) u (1 + mu tanh(l' / v_s)),
///
/// g normal with the gain's deviation, drawn at the start, n normal, anew each tick. The motor's own lag and
/// the drum are the plant's.
///
///     ports in   command  [N], one per cable
///                cables   for their rates
///     port out   tension  sampled [N]
///
/// @throws RunError in a run if one of them has another number of cables.
class WinchErrors final : public LeafSystem<WinchErrorsParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPort<CableVector> command{this, {"command", "N"}};
  InputPort<CableSignals> cables{this, {"cables"}};
  Random random{this, "random"};
  DiscreteState<CableVector> gain{this, {"gain"}, CableVector::Zero(params.num_cables)};
  Update<CableVector> draw{gain, AtStart{}, Uses(random), &WinchErrors::Draw};
  OutputPort<CableVector> tension{this,
                                  {"tension", "N"},
                                  CableVector::Zero(params.num_cables),
                                  Sampled{params.rate},
                                  Uses(command, cables, gain, random),
                                  &WinchErrors::CalcTension};

 private:
  void Draw(RandomStream& random, CableVector* gain) const;
  void CalcTension(const CableVector& command, const CableSignals& cables, const CableVector& gain,
                   RandomStream& random, CableVector* tension) const;
};

}  // namespace tenon
