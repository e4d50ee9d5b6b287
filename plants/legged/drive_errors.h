#pragma once

#include <tenon/plants/signals/legged_signals.h>
#include <tenon/systems/block.h>

namespace tenon {

/// By default there are no errors.
struct DriveErrorsParams {
  Rate rate = Hz(1000);       ///< rate of the commands
  double gain_deviation = 0;  ///< relative standard deviation of each drive's torque constant
  double ripple = 0;          ///< relative standard deviation of the torque

  static FieldList Fields() {
    using P = DriveErrorsParams;
    return {Undescribed(&P::rate), Field("gain_deviation", &P::gain_deviation).Between(0, 0.5),
            Field("ripple_ratio", &P::ripple).Between(0, 0.5)};
  }
};

/// Errors of drives: deviations of the torque constants, and torque ripple. At walking speeds motor and gear
/// rotate by many poles and teeth within a tick, so the ripple is white from tick to tick. A command u yields
///
///     y = (1 + g) (1 + ripple n) u,   g normal with the gain's deviation, drawn at the start, n normal, anew
///     each tick.
class DriveErrors final : public LeafSystem<DriveErrorsParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPort<Vec<12>> command{this, {"command", "N m"}};
  Random random{this, "random"};
  DiscreteState<Vec<12>> gain{this, {"gain", "", kJointElements}};
  Update<Vec<12>> draw{gain, AtStart{}, Uses(random), &DriveErrors::Draw};
  OutputPort<Vec<12>> torque{this,
                             {"torque", "N m", kJointElements},
                             Sampled{params.rate},
                             Uses(command, gain, random),
                             &DriveErrors::CalcTorque};

 private:
  Vec<12> Draw(RandomStream& random) const {
    Vec<12> gain;
    for (double& each : gain) each = params.gain_deviation * random.Normal();
    return gain;
  }
  Vec<12> CalcTorque(const Vec<12>& command, const Vec<12>& gain, RandomStream& random) const {
    Vec<12> torque;
    for (int j = 0; j < kNumJoints; ++j)
      torque[j] = (1 + gain[j]) * (1 + params.ripple * random.Normal()) * command[j];
    return torque;
  }
};

}  // namespace tenon
