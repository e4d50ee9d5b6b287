#pragma once

#include <tenon/plants/signals/legged_signals.h>
#include <tenon/systems/primitives/fault_schedule.h>

namespace tenon {

struct JointLockParams {
  std::vector<int> joints = {};  ///< indices of the locked joints, 3 leg + i; empty: all
  FaultSchedule schedule = {};   ///< the whole run by default
  double stiffness = 5000;       ///< a torque of 60 N m turns a locked joint by 0.7 degrees [N m/rad]
  double damping = 20;           ///< [N m s/rad]
  Rate rate = Hz(1000);

  void Validate() const;  ///< throws ParameterError
};

/// Locks joints, to model a jammed gear or a closed brake. While the fault is active, each joint is held at
/// its angle q_0 of the first tick by
///
///     torque = -stiffness (q - q_0) - damping qd
///
/// in parallel to the drive and without its limits.
///
///     builder.Connect(loop.world.state, lock.state);
///     builder.Connect(lock.locks, loop.world.plant.locks);
///
/// `locks` combines `others`, from another JointLock, with the locks of this block. The fault is active while
/// t is within `schedule` and `active` is true.
///
/// With the default values a link of 0.1 kg m^2 settles at 220 rad/s with a damping ratio of 0.45, which
/// explicit integration follows with steps of a millisecond; ten times the stiffness takes three times as
/// many steps. A broken drive is not a lock: use a SignalFault of kind loss and size 1 in its torque, after
/// which the joint swings freely against its friction. The drive's torque sensor does not measure the lock;
/// observers estimate it as an external torque.
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
  Parameter<FaultSchedule> schedule{this, {"schedule"}, params.schedule, "time in which the fault acts"};
  Scratch<Memory> memory{this, "memory"};
  OutputPort<bool> acting{
      this, {"acting"}, Sampled{params.rate}, Uses(time, schedule, active), &JointLock::CalcActing};
  OutputPort<JointLocks> locks{
      this, {"locks"}, Sampled{params.rate}, Uses(state, others, acting, memory), &JointLock::CalcLocks};

 private:
  bool CalcActing(double time_now, const FaultSchedule& schedule_now, bool active_now) const {
    return active_now && schedule_now.Acts(time_now, params.rate);
  }
  JointLocks CalcLocks(const LeggedState& x, const JointLocks& others, bool acting, Memory& memory) const;
};

}  // namespace tenon
