#pragma once

#include <tenon/plants/signals/legged_signals.h>
#include <tenon/systems/framework/block/parameter.h>
#include <tenon/systems/framework/block/ports.h>
#include <tenon/systems/framework/block/state.h>
#include <tenon/systems/framework/block/system.h>
#include <tenon/systems/primitives/fault_schedule.h>

#include <vector>

namespace tenon {

struct JointLockParams {
  std::vector<int> joints = {};  ///< that stick, as quadruped_description.h counts them; empty: all
  FaultSchedule schedule = {};   ///< the whole run, unless given
  double stiffness = 5000;       ///< [N m/rad]; 60 N m turn a joint that sticks by 0.7 degrees
  double damping = 20;           ///< [N m s/rad]
  Rate rate = Hz(1000);

  void Validate() const;  ///< throws ParameterError
};

/// Joints that stick: a jammed gear, or a brake that closed. While the fault acts each of them is held where
/// it was at its first tick q_0, by
///
///     torque = -stiffness (q - q_0) - damping qd
///
/// at the joint, beside the drive, whose limits do not limit it.
///
///     builder.Connect(loop.world.state, lock.state);
///     builder.Connect(lock.locks, loop.world.plant.locks);
///
///     | port      | kind            | size          | unit     |
///     | state     | input           | LeggedState   |          |
///     | others    | input, optional | JointLocks    |          |
///     | active    | input, optional | bool          |          |
///     | schedule  | Parameter       | FaultSchedule | s        |
///     | locks     | output, sampled | JointLocks    |          |
///     | acting    | output, sampled | bool          |          |
///
/// `locks` are `others`, of another such block, and its own. The fault acts while t is within `schedule` and
/// `active` is true.
///
/// The numbers are a choice: a link of 0.1 kg m^2 settles at 220 rad/s, damped to 0.45 of critical, which
/// explicit integration follows with steps of a millisecond; a lock ten times stiffer takes thrice as many
/// steps. A drive that broke is no lock: a SignalFault of kind loss and size 1 in its torque, after which the
/// joint swings freely, against its friction. The drive's torque sensor does not see the lock; observers take
/// it for an external torque.
class JointLock final : public LeafSystem<JointLockParams> {
 public:
  using LeafSystem::LeafSystem;
  struct Memory {
    Vec<12> angle = Vec<12>::Zero();  ///< at the first tick of the fault
    bool acts = false;
    static FieldList Fields() { return {{"angle", &Memory::angle, "rad"}, {"acts", &Memory::acts}}; }
  };

  InputPort<LeggedState> state{this, {"state"}};
  InputPort<JointLocks> others{this, {"others"}, JointLocks{}};
  InputPort<bool> active{this, {"active"}, true};
  Parameter<FaultSchedule> schedule{this, {"schedule"}, params.schedule, "when it acts"};
  Scratch<Memory> memory{this, "memory"};
  OutputPort<bool> acting{
      this, {"acting"}, Sampled{params.rate}, Uses(time, schedule, active), &JointLock::CalcActing};
  OutputPort<JointLocks> locks{
      this, {"locks"}, Sampled{params.rate}, Uses(state, others, acting, memory), &JointLock::CalcLocks};

 private:
  bool CalcActing(double time, const FaultSchedule& schedule, bool active) const {
    return active && schedule.Acts(time, params.rate);
  }
  JointLocks CalcLocks(const LeggedState& x, const JointLocks& others, bool acting, Memory& memory) const;
};

}  // namespace tenon
