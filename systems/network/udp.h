#pragma once

#include <tenon/systems/block.h>
#include <tenon/systems/io/recording.h>
#include <tenon/systems/network/inbox.h>
#include <tenon/systems/network/internal/udp_ends.h>

#include <cstdint>
#include <memory>
#include <string>

namespace tenon {

struct UdpPublisherParams {
  std::string name = "";              ///< of the signal in the messages; dots make levels: "robot.state"
  std::string address = "127.0.0.1";  ///< of who receives: IPv4, IPv6, or the name of a host
  int port = 9870;                    ///< of who receives; PlotJuggler's
  Rate rate = Hz(100);
  void Validate() const { internal::CheckSignalName(name); }
};

template <class T = double>
struct UdpInputParams {
  std::string name = "";              ///< of the signal in the messages
  T initial = internal::Zeroed<T>();  ///< y until a message comes [unit]; its size is that of all messages
  Rate rate = Hz(1000);               ///< of taking over
  std::string unit = "";              ///< of y
  std::string elements = "";          ///< their names, if not those of T: as the sender's signal calls them
  std::string address = "127.0.0.1";  ///< of this machine; 0.0.0.0 takes messages from all others
  int port = 9871;                    ///< 0 lets the system choose
  bool lock_step = false;             ///< waits at each tick for the message of its time
  double timeout_s = 10;              ///< of waiting
  bool record = false;                ///< keeps what was taken over, with its ticks
  Recording<T> replay = {};           ///< if not empty: what is taken over, and no port is opened
  void Validate() const { internal::CheckSignalName(name); }
};

/// Sends a signal by UDP, one JSON object in a datagram per sample, as PlotJuggler's UDP server takes it and
/// UdpInput does:
///
///     {"timestamp":0.25,"cart":{"position":0.1,"velocity":-0.2}}
///
/// `timestamp` is the time of the run [s]. The elements have the names that logs give them, a dot being a
/// level. Numbers are written so that they read back bit for bit; "NaN", "Infinity" and "-Infinity" are
/// texts, since JSON has no such numbers: a UdpInput refuses them. What is no number is left out.
///
///     builder.Connect(cart.state, builder.Add<UdpPublisher<Vec<2>>>("to_plots", {.name = "cart"}).u);
///
///     | port | kind  | size |
///     | u    | input | T    |
///
/// Nobody need listen. A datagram that the system does not take is lost, and counted in `unsent`. Sending
/// allocates nothing after the first time. Throws ParameterError for an address that does not exist, and if T
/// holds no numbers; in the run RunError, if a message is longer than a datagram can be, 65507 bytes.
template <class T = double>
class UdpPublisher final : public LeafSystem<UdpPublisherParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPort<T> u{this, "u"};
  Scratch<std::uint64_t> unsent{this, "unsent"};
  Workspace<internal::JsonWriter> writer{this, "writer"};
  Publish send{this, "send", Sampled{params.rate}, Uses(time, u, unsent, writer), &UdpPublisher::Send};

 private:
  void Send(double time, const T& value, std::uint64_t& unsent, internal::JsonWriter& writer) const {
    if (!sender_.Send(time, u, &value, writer)) ++unsent;
  }
  internal::UdpSender sender_{params.name, params.address, params.port, internal::TypeInfoOf<T>()};
};

/// The door for values that come by UDP, as UdpPublisher sends them.
///
///     auto& speed = builder.Add<UdpInput<double>>("speed", {.name = "speed", .rate = Hz(100)});
///
/// At each of its ticks the message that came last is taken over, and held until the next; this holds for any
/// rate of the sender, since a thread of the block empties the socket all the time. Of more than 4096
/// messages between two ticks the oldest are not looked at. With `lock_step` a tick waits for the message
/// that carries its own time: two programs that send at each tick and receive in lock-step go on together,
/// however fast they are, and are one simulation (docs/network.md). Since all that does not depend on it is
/// sent before, it can wait for the answer to what is sent at the same tick.
///
///     | port | kind            | size | unit |
///     | y    | output, sampled | T    | unit |
///
/// A message must have all elements of the signal as numbers, flat ("cart.position") or nested, a number
/// "timestamp", and nothing else. Others are refused, also those with the text "NaN" for a number:
/// `context.Eval(speed.refused)` says how many there were, and why the last was. Recording and replay are
/// those of ExternalInput. The port belongs to the block: let one context run at a time.
///
/// Throws ParameterError if the address does not exist or the port is taken, or if T holds no numbers; in
/// lock-step RunError, if the message of a tick does not come in time or was lost.
template <class T = double>
class UdpInput final : public LeafSystem<UdpInputParams<T>> {
  using Base = LeafSystem<UdpInputParams<T>>;

 public:
  using Base::Base;
  using Base::params;

  Scratch<TakenOver<T>> taken{this, "taken", {params.initial, 0, {}}};
  Scratch<RefusedMessages> refused{this, "refused"};
  ExternalPort<T> y{this,
                    {"y", params.unit, params.elements},
                    params.initial,
                    Sampled{params.rate},
                    Uses(this->time, taken, refused),
                    &UdpInput::TakeOver};

  /// Where messages arrive.
  int port() const { return port_; }

 private:
  void TakeOver(double time, TakenOver<T>& taken, RefusedMessages& refused, T* y) const {
    internal::TakeOver(params, inbox_.get(), time, taken, refused);
    *y = taken.value;
  }

  std::unique_ptr<internal::Inbox> Open() {
    if (!params.replay.empty()) return nullptr;
    return internal::MakeUdpInbox(
        {params.name, params.address, params.port, y.spec(), {params.lock_step, params.timeout_s}},
        internal::TypeInfoOf<T>(), &params.initial, &port_);
  }

  int port_ = params.port;
  std::unique_ptr<internal::Inbox> inbox_ = Open();
};

}  // namespace tenon
