#pragma once

#include <tenon/systems/io/recording.h>

#include <mutex>

namespace tenon {

/// Messages that a block refused because they were invalid or had other elements than the signal.
struct RefusedMessages {
  std::uint64_t count = 0;
  std::string reason = "";  ///< reason of the last refusal
  static FieldList Fields() {
    return {{"count", &RefusedMessages::count}, {"reason", &RefusedMessages::reason}};
  }
};

namespace internal {

/// Determines which message a block takes and when.
struct Reception {
  bool lock_step;    ///< wait for the message with the tick's time; else take the last message
  double timeout_s;  ///< timeout of lock-step [s of wall-clock time]
};

/// Receives the messages for one block. It is not part of the context: a message can be taken only once.
class Inbox {
 public:
  /// Throws ParameterError unless the timeout is positive and finite.
  explicit Inbox(Reception reception);
  virtual ~Inbox() = default;

  /// Reads the message for the tick at `time` [s] into `value`; returns false if there is none. In lock-step,
  /// throws RunError at a timeout and if a later message arrives first.
  bool Take(double time, void* value, RefusedMessages& refused);
  /// Time of the last message by its sender's clock [s]; 0 before the first.
  double sent() const { return sent_; }

 protected:
  /// Maximal number of queued messages, and of messages that one tick reads.
  static constexpr std::size_t kMostMessages = 4096;

  /// Removes and returns the oldest message that was not yet returned; empty if none comes within
  /// `timeout_s`. The result is valid until the next call.
  virtual std::optional<std::span<const char>> Receive(double timeout_s) = 0;
  /// Reads a message. Returns an empty text, or the reason of a refusal, which leaves `value` unchanged.
  virtual std::string Read(std::span<const char> message, double* timestamp, void* value) = 0;
  /// Describes the source in messages: "signal 'cart' at 127.0.0.1:9870".
  virtual std::string Description() const = 0;

 private:
  bool TakeNewest(void* value, RefusedMessages& refused);
  void TakeThatOf(double time, void* value, RefusedMessages& refused);
  bool ReadOrRefuse(std::span<const char> message, void* value, RefusedMessages& refused);

  const Reception reception_;
  double sent_ = 0;
  std::mutex mutex_;
};

/// Takes over a tick's value from the recording in `params`, else from the inbox.
template <class T, class Params>
void TakeOver(const Params& params, Inbox* inbox, double time, TakenOver<T>& taken,
              RefusedMessages& refused) {
  if (!params.replay.empty()) {
    taken.Replay(params.replay, time);
  } else if (inbox->Take(time, &taken.value, refused)) {
    taken.Take(time, taken.value, params.record);
  }
}

}  // namespace internal
}  // namespace tenon
