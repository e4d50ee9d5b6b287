#include <tenon/systems/block.h>
#include <tenon/systems/network/inbox.h>

#include <fmt/core.h>

#include <chrono>

namespace tenon {

namespace internal {
namespace {

/// Compares times of ticks on both sides, which differ only by rounding: by less than any period, also at
/// large times.
double Rounding(double time) {
  return 1e-9 + 1e-15 * std::abs(time);
}

}  // namespace

Inbox::Inbox(Reception reception) : reception_(reception) {
  Demand(reception.timeout_s > 0 && std::isfinite(reception.timeout_s),
         fmt::format("timeout_s = {} must be positive and finite", reception.timeout_s));
}

bool Inbox::Take(double time, void* value, RefusedMessages& refused) {
  const std::lock_guard lock(mutex_);
  if (!reception_.lock_step) return TakeNewest(value, refused);
  TakeThatOf(time, value, refused);
  return true;
}

bool Inbox::ReadOrRefuse(std::span<const char> message, void* value, RefusedMessages& refused) {
  std::string reason = Read(message, &sent_, value);
  if (reason.empty()) return true;
  ++refused.count;
  refused.reason = std::move(reason);
  return false;
}

/// Takes the last message regardless of its time, because a restarted sender begins at 0.
bool Inbox::TakeNewest(void* value, RefusedMessages& refused) {
  bool taken = false;
  for (std::size_t i = 0; i < kMostMessages; ++i) {  // bounded, because a sender may be faster
    const auto message = Receive(0);
    if (!message) break;
    if (ReadOrRefuse(*message, value, refused)) taken = true;
  }
  return taken;
}

void Inbox::TakeThatOf(double time, void* value, RefusedMessages& refused) {
  using Clock = std::chrono::steady_clock;
  const auto end = Clock::now() + std::chrono::duration<double>(reception_.timeout_s);
  const std::uint64_t refused_before = refused.count;
  std::string last = "none came";
  for (bool first = true;; first = false) {
    const std::chrono::duration<double> left = end - Clock::now();
    if (!first && left.count() <= 0) break;  // also if other messages keep coming
    const auto message = Receive(std::max(0.0, left.count()));
    if (!message) break;
    if (!ReadOrRefuse(*message, value, refused)) continue;
    if (std::abs(sent_ - time) <= Rounding(time)) return;
    if (sent_ > time) {
      throw RunError(fmt::format(
          "{}: the message of t = {} s was lost, the next one has t = {} s: start the sender after this "
          "program, and use the same rate in both",
          Description(), time, sent_));
    }
    last = fmt::format("the last one has t = {} s", sent_);
  }
  if (refused.count > refused_before) {
    last += fmt::format("; {} were refused: {}", refused.count - refused_before, refused.reason);
  }
  throw RunError(
      fmt::format("{}: no message of t = {} s within {} s ({}): start the sender after this program, check "
                  "its address and "
                  "rate, or increase timeout_s",
                  Description(), time, reception_.timeout_s, last));
}

}  // namespace internal
}  // namespace tenon
