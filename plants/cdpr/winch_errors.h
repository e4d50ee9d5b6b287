#pragma once

#include <tenon/plants/signals/cdpr_signals.h>
#include <tenon/systems/block.h>

namespace tenon {

/// Errors of the winches. By default there are none.
struct WinchErrorsParams {
  int num_cables = 4;
  Rate rate = Hz(1000);           ///< rate of the commands
  double gain_deviation = 0;      ///< relative standard deviation of the winches' torque constants
  double ripple = 0;              ///< relative standard deviation of the tension
  double friction = 0;            ///< mu, coefficient of dry friction
  double friction_speed = 0.005;  ///< v_s, at which the friction reaches 76 % of its bound [m/s]

  bool any() const { return gain_deviation > 0 || ripple > 0 || friction > 0; }
  static FieldList Fields() {
    using P = WinchErrorsParams;
    return {Undescribed("num_cables", &P::num_cables).Positive(),
            Undescribed(&P::rate),
            Field("gain_deviation", &P::gain_deviation).Between(0, 0.5),
            Field("ripple_ratio", &P::ripple).Between(0, 0.5),
            Field("friction_ratio", &P::friction).Between(0, 0.5),
            Field("friction_speed_m_per_s", &P::friction_speed).Positive()};
  }
};

/// Errors of winches: gains that deviate from the model, torque ripple (modelled as white from tick to tick,
/// see DriveErrors), and dry friction of gear, drum and pulleys. The tension for a command u of a cable whose
/// length changes at l' (positive when it is pulled out) is
///
///     y = (1 + g) (1 + ripple n) u (1 + mu tanh(l' / v_s)),
///
/// with g normal with the gain's deviation, drawn at the start, and n standard normal, drawn at each tick.
/// The plant models the motor's lag and the drum.
///
/// @throws RunError during a run if an input does not have one entry per cable.
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
