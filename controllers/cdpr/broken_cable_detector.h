#pragma once

#include <tenon/plants/signals/cdpr_signals.h>
#include <tenon/systems/framework/block/ports.h>
#include <tenon/systems/framework/block/state.h>
#include <tenon/systems/framework/block/system.h>

namespace tenon {

struct BrokenCableDetectorParams {
  int num_cables = 4;
  double reel_damping = 90;  ///< b of the winches, see CdprDescription [N s/m]
  Rate rate = Hz(1000);
  double share = 0.2;         ///< of what it should pull: with less, a cable does not pull
  double least_tension = 20;  ///< that it should pull; less tells nothing [N]
  double patience = 0.05;     ///< for so long; more than the lag of a winch [s]
  void Validate() const;      ///< throws ParameterError
};

/// Which cables broke, from what is measured of them. A cable that is paid out or in at dl/dt should pull
/// with
///
///     T = u + b dl/dt,
///
/// u the command of its winch. It broke if it has pulled with less than `share` of that for `patience`
/// without a break, although it is no shorter than what its winch has paid out and T is `least_tension` at
/// least. What broke stays so. If no cable pulls it is the measurement that fails, and none counts as broken;
/// a load cell that fails alone looks as a cable that broke.
///
///     ports in  cables   as measured
///               command  to the winches [N]
///     port out  broken   1 if so, else 0, one per cable, sampled; a tick later, so that the command may
///                        depend on it
///
/// @throws RunError in the loop if the signals are those of another number of cables.
class BrokenCableDetector final : public LeafSystem<BrokenCableDetectorParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPort<CableSignals> cables{this, {"cables"}};
  InputPort<CableVector> command{this, {"command", "N"}};
  /// For how long each has not pulled; of those that broke, for `patience`.
  DiscreteState<CableVector> missing{this, {"missing", "s"}, CableVector::Zero(params.num_cables)};
  Update<CableVector> next{missing, Sampled{params.rate}, Uses(missing, cables, command),
                           &BrokenCableDetector::CalcNext};
  OutputPort<CableVector> broken{this,
                                 {"broken"},
                                 CableVector::Zero(params.num_cables),
                                 Sampled{params.rate},
                                 Uses(missing),
                                 &BrokenCableDetector::CalcBroken};

 private:
  void CalcNext(const CableVector& missing, const CableSignals& cables, const CableVector& command,
                CableVector* next) const;
  void CalcBroken(const CableVector& missing, CableVector* broken) const;
};

}  // namespace tenon
