#pragma once

#include <tenon/plants/signals/cdpr_signals.h>
#include <tenon/systems/primitives/fault_schedule.h>

namespace tenon {

enum class CableFaultKind {
  kStuck,   ///< the winch's drum does not turn: the cable keeps its rest length, and its strain its tension
  kBroken,  ///< the cable has no tension until the end of the run
};
constexpr auto EnumNames(CableFaultKind) {
  return std::array{Named{CableFaultKind::kStuck, "stuck"}, Named{CableFaultKind::kBroken, "broken"}};
}

struct CableFaultParams {
  CableFaultKind kind = CableFaultKind::kStuck;
  int num_cables = 0;            ///< number of the robot's cables
  std::vector<int> cables = {};  ///< indices of the faulty cables, from 0; empty: all cables
  FaultSchedule schedule = {};   ///< default: the whole run; broken cables stay broken
  Rate rate = Hz(1000);

  void Validate() const;  ///< throws ParameterError
};

/// Makes winches stick or cables break; see CdprPlant for the consequences.
///
///     builder.Connect(fault.faults, loop.world.plant.faults);
///
/// `faults` is the union of `others`, the output of another such block, and the faults of this block. The
/// fault acts while t is within `schedule` and `active` is true; a broken cable stays broken. The tensions
/// depend on `faults` without delay, so an `active` that depends on tensions (a cable that breaks under
/// overload) needs a UnitDelay.
class CableFault final : public LeafSystem<CableFaultParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPort<CableFaults> others{this, {"others"}, CableFaults{}};
  InputPort<bool> active{this, {"active"}, true};
  Parameter<FaultSchedule> schedule{this, {"schedule"}, params.schedule, "time in which the fault acts"};
  Scratch<bool> acted{this, "acted"};
  OutputPort<bool> acting{
      this, {"acting"}, Sampled{params.rate}, Uses(time, schedule, active, acted), &CableFault::CalcActing};
  OutputPort<CableFaults> faults{this,
                                 {"faults"},
                                 Sound(params.num_cables),
                                 Sampled{params.rate},
                                 Uses(others, acting),
                                 &CableFault::CalcFaults};

 private:
  static CableFaults Sound(int num_cables) {
    const CableVector none = CableVector::Zero(num_cables);
    return {none, none};
  }
  bool CalcActing(double time, const FaultSchedule& schedule, bool active, bool& acted) const;
  void CalcFaults(const CableFaults& others, bool acting, CableFaults* out) const;
};

}  // namespace tenon
