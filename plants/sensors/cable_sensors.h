#pragma once

#include <tenon/plants/signals/cdpr_signals.h>
#include <tenon/systems/block.h>

namespace tenon {

/// Encoders on the drums and load cells. By default there are no errors, and rates are measured.
struct CableSensorsParams {
  int num_cables = 4;
  Rate rate = Hz(1000);       ///< sample rate
  double resolution = 0;      ///< resolution of the lengths; 0: unlimited [m]
  double length_offset = 0;   ///< standard deviation of each cable's homing error [m]
  double rate_bandwidth = 0;  ///< cut-off frequency of differentiated lengths; 0: rates are measured [Hz]
  double tension_noise = 0;   ///< standard deviation relative to the tension
  double tension_offset = 0;  ///< standard deviation of each load cell's offset [N]

  static FieldList Fields() {
    using P = CableSensorsParams;
    return {Undescribed("num_cables", &P::num_cables).Positive(),
            {"rate_hz", &P::rate},
            Field("resolution_m", &P::resolution).AtLeast(0),
            Field("offset_m", &P::length_offset).AtLeast(0),
            Field("rate_bandwidth_hz", &P::rate_bandwidth).AtLeast(0),
            Field("tension_noise_ratio", &P::tension_noise).AtLeast(0),
            Field("tension_offset_N", &P::tension_offset).AtLeast(0)};
  }
};

/// Measures the lengths of cables by encoders on the drums and their tensions by load cells. The strain of
/// the cables is assumed to be compensated exactly by the tension.
///
///     length   true length plus offset, rounded to the resolution
///     rate     r[k] = a r[k - 1] + (1 - a) / h (l[k] - l[k - 1]),   a = exp(-2 pi bandwidth h)
///     tension  T (1 + noise n) plus offset, at least 0
///
/// Offsets are normal and drawn at the start; n is normal and drawn at each sample. rest_length has the
/// errors of the length.
///
/// @throws RunError during the run if the number of cables of the input differs.
class CableSensors final : public LeafSystem<CableSensorsParams> {
 public:
  using LeafSystem::LeafSystem;

  /// Offsets of the sensors of a robot.
  struct Offsets {
    CableVector length;   ///< [m]
    CableVector tension;  ///< [N]
    static FieldList Fields() {
      return {{"length", &Offsets::length, "m"}, {"tension", &Offsets::tension, "N"}};
    }
  };
  /// Values of the last sample.
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
