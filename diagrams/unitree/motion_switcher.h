#pragma once

#include <tenon/systems/dds/dds.h>

#include <cstdint>
#include <string>

namespace tenon {

/// A request to the motion switcher of a robot, topic "rt/api/motion_switcher/request".
struct SwitcherRequest {
  static constexpr std::int64_t kCheck = 1001, kRelease = 1003;

  std::int64_t id = 0;      ///< the answer has the same
  std::int64_t action = 0;  ///< kCheck, kRelease or another number
  static FieldList Fields() { return {{"id", &SwitcherRequest::id}, {"action", &SwitcherRequest::action}}; }
};

/// The answer, topic "rt/api/motion_switcher/response".
struct SwitcherAnswer {
  std::int64_t id = 0;
  std::int64_t action = 0;
  int code = 0;         ///< 0: done
  bool active = false;  ///< a built-in mode runs; known after kCheck
  static FieldList Fields() {
    using S = SwitcherAnswer;
    return {{"id", &S::id}, {"action", &S::action}, {"code", &S::code}, {"active", &S::active}};
  }
};

template <>
struct DdsMessageOf<SwitcherRequest> {
  static const DdsMessage& Get();
};
template <>
struct DdsMessageOf<SwitcherAnswer> {
  static const DdsMessage& Get();
};

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

/// The motion switcher of a simulated robot: a built-in mode runs until a client releases it. It affects no
/// other block, because a robot on DDS follows commands at any time.
///
///     scratch active  whether the built-in mode runs
class MotionSwitcher final : public LeafSystem<MotionSwitcherParams> {
 public:
  using LeafSystem::LeafSystem;
  Scratch<bool> active{this, "active", true};
  Publish answer{this, "answer", Sampled{params.rate}, Uses(active), &MotionSwitcher::Answer};

 private:
  void Answer(bool& active_now) const;
  std::unique_ptr<internal::Inbox> inbox_ =
      params.silent ? nullptr
                    : internal::MakeDdsInbox({"rt/api/motion_switcher/request", params.link, false},
                                             DdsMessageOf<SwitcherRequest>::Get(), 1);
  std::unique_ptr<internal::DdsSender> sender_ =
      params.silent ? nullptr
                    : internal::MakeDdsSender({"rt/api/motion_switcher/response", params.link, false},
                                              DdsMessageOf<SwitcherAnswer>::Get());
};

}  // namespace tenon
