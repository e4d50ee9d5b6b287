#pragma once

#include <tenon/plants/signals/cdpr_signals.h>
#include <tenon/systems/block.h>

namespace tenon {

struct BrokenCableDetectorParams {
  int num_cables = 4;
  double reel_damping = 90;  ///< b of the winches, see CdprDescription [N s/m]
  Rate rate = Hz(1000);
  double share = 0.2;         ///< threshold of the measured over the expected tension
  double least_tension = 20;  ///< dead band: below this expected tension no cable is judged [N]
  double patience = 0.05;     ///< time below the threshold, longer than the lag of a winch [s]

  static FieldList Fields() {
    using P = BrokenCableDetectorParams;
    return {Undescribed("num_cables", &P::num_cables).Positive(),
            Undescribed("reel_damping", &P::reel_damping).AtLeast(0),
            Undescribed(&P::rate),
            Undescribed("share", &P::share).Above(0).Below(1),
            Undescribed("least_tension", &P::least_tension).Positive(),
            Undescribed("patience", &P::patience).Positive()};
  }
};

/// Detects broken cables from measured lengths and tensions. The expected tension of a cable whose length
/// changes at dl/dt is
///
///     T = u + b dl/dt,
///
/// where u is the command of its winch. A cable is reported as broken if its measured tension has been below
/// `share` T for an uninterrupted `patience`, while its length was at least its rest length and T at least
/// `least_tension`. A broken cable stays broken. If the measured tensions of all cables are below their
/// thresholds, the measurement is assumed to have failed and no cable is reported. The failure of a single
/// load cell cannot be distinguished from a broken cable.
///
/// `broken` is 1 for a broken cable, else 0, and delayed by a tick, so that the command may depend on it.
///
/// @throws RunError during a run if a signal does not have one entry per cable.
class BrokenCableDetector final : public LeafSystem<BrokenCableDetectorParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPort<CableSignals> cables{this, {"cables"}};
  InputPort<CableVector> command{this, {"command", "N"}};
  /// Time for which each cable has been below its threshold [s]; `patience` for broken cables.
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
  void CalcBroken(const CableVector& missing, CableVector* broken) const {
    *broken = (missing.array() >= params.patience).cast<double>();
  }
};

}  // namespace tenon
