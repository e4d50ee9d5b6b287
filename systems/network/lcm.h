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
  std::string url = "";               ///< as that of LcmPublisher
  T initial = internal::Zeroed<T>();  ///< y until a message comes [unit]; its size is that of all messages
  Rate rate = Hz(1000);               ///< of taking over
  std::string unit = "";              ///< of y
  bool lock_step = false;             ///< waits at each tick for the message of its time
  double timeout_s = 10;              ///< of waiting
  bool record = false;                ///< keeps what was taken over, with its ticks
  Recording<T> replay = {};           ///< if not empty: what is taken over, and nothing is subscribed
  void Validate() const { internal::CheckChannel(channel); }
};

/// The description of the messages that carry a T, for lcm-gen: with the code that it makes of it, any
/// program reads and writes them, as lcm-spy does. A struct becomes a struct, a matrix an array by rows; see
/// network/internal/lcm_type.h for the rest. Throws ParameterError for what LCM does not have.
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
/// A message that LCM does not take is lost, and counted in `unsent`. Throws ParameterError if LCM does not
/// open the URL, and for a T that LCM has no type for.
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

/// The door for values that come by LCM, from LcmPublisher or from code that lcm-gen has made.
///
///     | port | kind            | size | unit |
///     | y    | output, sampled | T    | unit |
///
/// What it takes over when, lock-step, recording, replay and what is refused are those of UdpInput. Messages
/// of another type are refused. Let one context run at a time.
///
/// Throws ParameterError if LCM does not open the URL or does not receive there, and for a T that LCM has no
/// type for; in lock-step RunError, if the message of a tick does not come in time or was lost.
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
