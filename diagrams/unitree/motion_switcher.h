#pragma once

#include <tenon/systems/dds/dds.h>

namespace tenon {

/// Asks the motion switcher of a robot to end the built-in mode, until none runs, so that the robot follows
/// "rt/lowcmd" alone. The robot must lie, because it falls if it stands. Returns false if nobody answers
/// within `patience_s` at the interface "lo", where there are simulators without a built-in mode. Throws
/// ParameterError if nobody answers elsewhere, or if the mode still runs after five times that time.
bool LeaveBuiltInMode(const DdsLink& link, double patience_s = 2);

struct MotionSwitcherParams {
  DdsLink link = {.domain = 1, .interface = "lo"};
  Rate rate = Hz(50);   ///< rate at which requests are answered
  bool silent = false;  ///< does not join DDS, as in the replay of a run
};

/// The motion switcher of a simulated robot: a built-in mode runs until a client releases it. It answers the
/// requests 1001, which names the mode, and 1003, which releases it, and refuses others. It affects no other
/// block, because a robot on DDS follows commands at any time.
class MotionSwitcher final : public LeafSystem<MotionSwitcherParams> {
 public:
  explicit MotionSwitcher(const MotionSwitcherParams& params = {});
  Scratch<bool> active{this, "active", true};  ///< the built-in mode runs
  Publish answer{this, "answer", Sampled{params.rate}, Uses(active), &MotionSwitcher::Answer};

 private:
  void Answer(bool& active_now) const;
  std::unique_ptr<internal::Inbox> requests_;
  std::unique_ptr<internal::DdsSender> answers_;
};

}  // namespace tenon
