#pragma once

#include <tenon/systems/framework/types/fields.h>
#include <tenon/systems/io/recording.h>

#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace tenon {

/// What came to a block and was not taken: it could not be read, or had other elements than the signal.
struct RefusedMessages {
  std::uint64_t count = 0;
  std::string reason = "";  ///< of the last one
  static FieldList Fields() {
    return {{"count", &RefusedMessages::count}, {"reason", &RefusedMessages::reason}};
  }
};

namespace internal {

/// When a block takes which message.
struct Reception {
  bool lock_step;    ///< waits for the message that carries the tick's own time; else the one that came last
  double timeout_s;  ///< of waiting
};

/// Where the messages for one block arrive. It lies outside of the run: what is taken from it is gone.
class Inbox {
 public:
  /// Throws ParameterError unless the timeout is positive.
  explicit Inbox(Reception reception);
  virtual ~Inbox() = default;

  /// Reads what is to be taken at `time` [s] into `value`; false if nothing has come. In lock-step throws
  /// RunError at a timeout, and if a later message comes first.
  bool Take(double time, void* value, RefusedMessages& refused);

 protected:
  /// How many messages wait for a tick at most; of more, the oldest are dropped unread.
  static constexpr std::size_t kMostMessages = 4096;
  using Messages = std::deque<std::vector<char>>;

  /// All messages that wait, in their order: whatever the rates are, the newest is among them.
  virtual Messages TakeAll() = 0;
  /// In lock-step: the next message, waiting for it as long [s]; nothing if none comes. It is read before the
  /// next.
  virtual std::optional<std::span<const char>> Receive(double timeout_s) = 0;
  /// Returns why the message is refused, with `value` as it was; empty if it is not.
  virtual std::string Read(std::span<const char> message, double* timestamp, void* value) = 0;
  /// "signal 'cart' at 127.0.0.1:9870"
  virtual std::string Description() const = 0;

 private:
  bool TakeNewest(void* value, RefusedMessages& refused);
  void TakeThatOf(double time, void* value, RefusedMessages& refused);
  bool ReadOrRefuse(std::span<const char> message, double* timestamp, void* value, RefusedMessages& refused);

  const Reception reception_;
  std::mutex mutex_;
};

/// What a tick takes over: from the recording that `params` names, else from the inbox.
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
