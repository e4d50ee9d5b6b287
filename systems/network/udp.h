#pragma once

#include <tenon/systems/block.h>
#include <tenon/systems/network/inbox.h>
#include <tenon/systems/network/internal/json.h>

namespace tenon {

namespace internal {

class UdpSocket;

/// The part of UdpPublisher that does not depend on its type.
class UdpSender {
 public:
  UdpSender(const std::string& name, const std::string& address, int port, const TypeInfo& type);
  ~UdpSender();
  /// Returns false if the message was not sent. `port` determines the names of the elements.
  bool Send(double time, const Source& port, const void* value, JsonWriter& writer) const;

 private:
  const std::string name_;
  std::unique_ptr<UdpSocket> socket_;
};

struct UdpReception {
  std::string name, address;
  int port;
  Spec spec;  ///< spec of y
  Reception reception;
};
/// Makes the inbox of a UdpInput of any type. Sets `port` to the actual port.
std::unique_ptr<Inbox> MakeUdpInbox(const UdpReception& reception, const TypeInfo& type, const void* model,
                                    int* port);
void CheckSignalName(const std::string& name);

}  // namespace internal

struct UdpPublisherParams {
  std::string name = "";              ///< name of the signal in the messages; dots make levels: "robot.state"
  std::string address = "127.0.0.1";  ///< address of the receiver: IPv4, IPv6, or a host name
  int port = 9870;                    ///< port of the receiver; the default is PlotJuggler's
  Rate rate = Hz(100);
  void Validate() const { internal::CheckSignalName(name); }
};

template <class T = double>
struct UdpInputParams {
  std::string name = "";              ///< name of the signal in the messages
  T initial = internal::Zeroed<T>();  ///< y until the first message [unit]; determines the size of messages
  Rate rate = Hz(1000);               ///< rate at which y takes over messages
  std::string unit = "";              ///< unit of y
  std::string elements = "";          ///< names of the elements as in the sender's signal, if not those of T
  std::string address = "127.0.0.1";  ///< address of this machine; 0.0.0.0 receives from all machines
  int port = 9871;                    ///< 0: chosen by the system
  bool lock_step = false;             ///< each tick waits for the message with its time
  double timeout_s = 10;              ///< timeout of lock-step [s of wall-clock time]
  bool record = false;                ///< records the values and the times at which y took them over
  Recording<T> replay = {};           ///< if not empty, y follows this recording and no port is opened
  void Validate() const { internal::CheckSignalName(name); }
};

/// Sends a signal by UDP as one datagram with a JSON object per sample, for UdpInput or PlotJuggler's UDP
/// server:
///
///     {"timestamp":0.25,"cart":{"position":0.1,"velocity":-0.2}}
///
/// `timestamp` is the time of the run [s]. The elements are named as in logs, with one level of objects for
/// each dot. Numbers read back bit for bit. "NaN", "Infinity" and "-Infinity" are texts, because JSON has no
/// such numbers; UdpInput refuses them. Members that are not numbers are omitted.
///
///     builder.Connect(cart.state, builder.Add<UdpPublisher<Vec<2>>>("to_plots", {.name = "cart"}).u);
///
/// No receiver is required. Datagrams that the system refuses are lost and counted in `unsent`. Only the
/// first message allocates. Throws ParameterError if the address does not exist or T holds no numbers. During
/// the run, throws RunError if a message exceeds the 65507 bytes of a datagram.
template <class T = double>
class UdpPublisher final : public LeafSystem<UdpPublisherParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPort<T> u{this, "u"};
  Scratch<std::uint64_t> unsent{this, "unsent"};
  Workspace<internal::JsonWriter> writer{this, "writer"};
  Publish send{this, "send", Sampled{params.rate}, Uses(time, u, unsent, writer), &UdpPublisher::Send};

 private:
  void Send(double t, const T& value, std::uint64_t& lost, internal::JsonWriter& json) const {
    if (!sender_.Send(t, u, &value, json)) ++lost;
  }
  internal::UdpSender sender_{params.name, params.address, params.port, internal::TypeInfoOf<T>()};
};

/// An input for values that UdpPublisher or another program sends by UDP.
///
///     auto& speed = builder.Add<UdpInput<double>>("speed", {.name = "speed", .rate = Hz(100)});
///
/// At each tick, y takes over the last message and holds it until the next tick. This works at any rate of
/// the sender, because a thread of the block empties the socket continuously. If more than 4096 messages
/// arrive between two ticks, the oldest are dropped. With `lock_step`, a tick waits for the message with its
/// own time: two programs that send at each tick and receive in lock-step are synchronised to one simulation
/// (docs/network.md). A tick can wait for the answer to a message of the same tick, because everything that
/// does not depend on y is sent before.
///
/// A message must have all elements of the signal as numbers, flat ("cart.position") or nested, a number
/// "timestamp", and no other keys. Other messages are refused, also those with the text "NaN";
/// `context.Eval(speed.refused)` returns their number and the last reason. Recording and replay work as in
/// ExternalInput. The port belongs to the block, so run only one context at a time.
///
/// Throws ParameterError if the address does not exist, the port is in use or T holds no numbers. In
/// lock-step, throws RunError if the message of a tick is late or lost.
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

  /// The actual port.
  int port() const { return port_; }

 private:
  void TakeOver(double t, TakenOver<T>& taken_now, RefusedMessages& refused_now, T* y_out) const {
    internal::TakeOver(params, inbox_.get(), t, taken_now, refused_now);
    *y_out = taken_now.value;
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
