#pragma once

#include <tenon/systems/block.h>
#include <tenon/systems/io/recording.h>
#include <tenon/systems/network/inbox.h>
#include <tenon/systems/network/internal/lcm_ends.h>
#include <tenon/systems/network/internal/lcm_type.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace tenon {

struct LcmPublisherParams {
  std::string channel = "";  ///< 1 to 63 characters
  std::string url = "";  ///< LCM's provider; empty for LCM_DEFAULT_URL, or udpm://239.255.76.67:7667?ttl=0
  Rate rate = Hz(100);
  void Validate() const { internal::CheckChannel(channel); }
};

template <class T = double>
struct LcmInputParams {
  std::string channel = "";           ///< 1 to 63 characters
  std::string url = "";               ///< LCM's provider, see LcmPublisherParams
  T initial = internal::Zeroed<T>();  ///< y until the first message [unit]; determines the size of messages
  Rate rate = Hz(1000);               ///< rate at which y takes over messages
  std::string unit = "";              ///< unit of y
  bool lock_step = false;             ///< each tick waits for the message with its time
  double timeout_s = 10;              ///< timeout of lock-step [s of wall-clock time]
  bool record = false;                ///< records the values and the times at which y took them over
  Recording<T> replay = {};           ///< if not empty, y follows this recording without a subscription
  void Validate() const { internal::CheckChannel(channel); }
};

/// Returns the description of the messages of a T for lcm-gen, whose code reads and writes them in other
/// programs, for example lcm-spy. A struct becomes a struct, a matrix an array by rows; see
/// network/internal/lcm_type.h for other types. Throws ParameterError for types that LCM does not support.
///
///     package robot;
///
///     struct SpringState {
///       double force;  // N
///       double p_W[3];  // m
///     }
///
///     struct SpringStateSample {
///       double timestamp;  // s
///       SpringState value;
///     }
template <class T>
std::string LcmTypeOf(const std::string& package) {
  return internal::LcmType(internal::TypeInfoOf<T>()).Text(package);
}

/// Sends a signal by LCM, one message per sample, of the type that LcmTypeOf describes.
///
///     builder.Connect(cart.state, builder.Add<LcmPublisher<CartState>>("to_lcm", {.channel = "CART"}).u);
///
///     | port | kind  | size |
///     | u    | input | T    |
///
/// Messages that LCM refuses are lost and counted in `unsent`. Throws ParameterError if LCM cannot open the
/// URL or does not support the type T.
template <class T = double>
class LcmPublisher final : public LeafSystem<LcmPublisherParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPort<T> u{this, "u"};
  Scratch<std::uint64_t> unsent{this, "unsent"};
  Workspace<std::vector<char>> message{this, "message"};
  Publish send{this, "send", Sampled{params.rate}, Uses(time, u, unsent, message), &LcmPublisher::Send};

 private:
  void Send(double time, const T& value, std::uint64_t& unsent, std::vector<char>& message) const {
    if (!sender_.Send(time, &value, message)) ++unsent;
  }
  internal::LcmSender sender_{params.channel, params.url, internal::TypeInfoOf<T>()};
};

/// An input for values from LCM, sent by LcmPublisher or by code from lcm-gen.
///
///     | port | kind            | size | unit |
///     | y    | output, sampled | T    | unit |
///
/// Takes over values, refuses messages, records and replays as UdpInput does. Messages of another type are
/// refused. Run only one context at a time.
///
/// Throws ParameterError if LCM cannot open the URL, cannot receive there or does not support the type T. In
/// lock-step, throws RunError if the message of a tick is late or lost.
template <class T = double>
class LcmInput final : public LeafSystem<LcmInputParams<T>> {
  using Base = LeafSystem<LcmInputParams<T>>;

 public:
  using Base::Base;
  using Base::params;

  Scratch<TakenOver<T>> taken{this, "taken", {params.initial, 0, {}}};
  Scratch<RefusedMessages> refused{this, "refused"};
  ExternalPort<T> y{this,
                    {"y", params.unit},
                    params.initial,
                    Sampled{params.rate},
                    Uses(this->time, taken, refused),
                    &LcmInput::TakeOver};

 private:
  void TakeOver(double time, TakenOver<T>& taken, RefusedMessages& refused, T* y) const {
    internal::TakeOver(params, inbox_.get(), time, taken, refused);
    *y = taken.value;
  }

  std::unique_ptr<internal::Inbox> inbox_ =
      params.replay.empty()
          ? internal::MakeLcmInbox(params.channel, params.url, {params.lock_step, params.timeout_s},
                                   internal::TypeInfoOf<T>())
          : nullptr;
};

}  // namespace tenon
