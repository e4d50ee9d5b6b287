#pragma once

#include <tenon/plants/signals/cdpr_signals.h>
#include <tenon/systems/framework/block/ports.h>
#include <tenon/systems/framework/block/state.h>
#include <tenon/systems/framework/block/system.h>

namespace tenon {

/// Defaults: without errors, rates that are measured.
struct CableSensorsParams {
  int num_cables = 4;
  Rate rate = Hz(1000);
  double resolution = 0;      ///< between two lengths that are told apart; 0: all are [m]
  double length_offset = 0;   ///< standard deviation, by cable: as it was homed [m]
  double rate_bandwidth = 0;  ///< of the differences that stand for rates; 0: rates are measured [Hz]
  double tension_noise = 0;   ///< standard deviation over tension
  double tension_offset = 0;  ///< standard deviation, by load cell [N]

  void Validate() const;  ///< throws ParameterError
};

/// The lengths of cables by encoders on the drums, their tensions by load cells, at a rate. What a cable
/// stretches by the drum does not see; it is taken as compensated exactly by the tension.
///
///     length   the true one and an offset of its own, rounded to the resolution
///     rate     r[k] = a r[k - 1] + (1 - a) / h (l[k] - l[k - 1]),   a = exp(-2 pi bandwidth h)
///     tension  T (1 + noise n) and an offset of its own, not below 0
///
/// Offsets are normal, drawn at the start, n normal, anew at each sample. What is paid out, rest_length, has
/// the length's errors.
///
///     port in   cables
///     port out  measured  sampled
///
/// @throws RunError in the loop if the signals are those of another number of cables.
class CableSensors final : public LeafSystem<CableSensorsParams> {
 public:
  using LeafSystem::LeafSystem;

  /// What the sensors of one robot have.
  struct Offsets {
    CableVector length;   ///< [m]
    CableVector tension;  ///< [N]
    static FieldList Fields() {
      return {{"length", &Offsets::length, "m"}, {"tension", &Offsets::tension, "N"}};
    }
  };
  /// Of the sample before.
  struct Memory {
    bool started = false;
    CableVector length;  ///< [m]
    CableVector rate;    ///< [m/s]
    static FieldList Fields() {
      return {
          {"started", &Memory::started}, {"length", &Memory::length, "m"}, {"rate", &Memory::rate, "m/s"}};
    }
  };

  InputPort<CableSignals> cables{this, {"cables"}};
  Random random{this, "random"};
  Scratch<Memory> memory{this, "memory", Memory{false, Zero(), Zero()}};
  DiscreteState<Offsets> offsets{this, {"offsets"}, Offsets{Zero(), Zero()}};
  Update<Offsets> draw{offsets, AtStart{}, Uses(random), &CableSensors::Draw};
  OutputPort<CableSignals> measured{this,
                                    {"measured"},
                                    CableSignals::Zero(params.num_cables),
                                    Sampled{params.rate},
                                    Uses(cables, offsets, random, memory),
                                    &CableSensors::CalcMeasured};

 private:
  CableVector Zero() const { return CableVector::Zero(params.num_cables); }
  void Draw(RandomStream& random, Offsets* offsets) const;
  void CalcMeasured(const CableSignals& cables, const Offsets& offsets, RandomStream& random, Memory& memory,
                    CableSignals* measured) const;
};

}  // namespace tenon
