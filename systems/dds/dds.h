#pragma once

#include <tenon/systems/block.h>
#include <tenon/systems/dds/internal/dds_ends.h>
#include <tenon/systems/ros2/messages.h>

namespace tenon {

/// Maps a signal of type T to a message of DDS. Specialise it for each signal that travels by DDS, with a
/// function `static const DdsMessage& Get();`, and define this function in a .cc, which alone includes the
/// header that `idlc` writes:
///
///     void Write(const CartState& x, demo_Cart& message) { message.position = x.position; }
///     std::string Read(const demo_Cart& message, CartState& x) { return x.position = message.position, ""; }
///     const DdsMessage& DdsMessageOf<CartState>::Get() {
///       static const auto kMessage = MakeDdsMessage<demo_Cart, CartState, Write, Read>(&demo_Cart_desc);
///       return kMessage;
///     }
template <class T>
struct DdsMessageOf {
  static_assert(internal::kFalse<T>, "This signal has no DDS message: specialise tenon::DdsMessageOf.");
};

/// Makes the mapping between a C struct of idlc and a signal. `write(signal, message)` fills a message whose
/// bytes are zero, and `read(message, signal)` returns an empty text or the reason why it refuses the
/// message. A signal with a number that is not finite is refused, too. `descriptor` points to the struct's
/// dds_topic_descriptor_t. Strings and sequences of the struct exist only during `read`; `write` may let them
/// point into the signal, with `_release` false.
template <class Message, class T, auto write, auto read>
DdsMessage MakeDdsMessage(const void* descriptor) {
  return {
      .descriptor = descriptor,
      .size = sizeof(Message),
      .write = [](const void* signal,
                  void* message) { write(*static_cast<const T*>(signal), *static_cast<Message*>(message)); },
      .read = [](const void* message, void* signal) -> std::string {
        T candidate = *static_cast<const T*>(signal);
        std::string reason = read(*static_cast<const Message*>(message), candidate);
        if (reason.empty()) reason = internal::NotFinite(internal::TypeInfoOf<T>(), &candidate);
        if (reason.empty()) *static_cast<T*>(signal) = candidate;
        return reason;
      }};
}

/// Makes the mapping of a message of ROS 2 that is not in systems/ros2/messages.h, whose struct has the
/// members of the IDL in the same order. `descriptor` points to its dds_topic_descriptor_t.
template <ros2::Message T>
DdsMessage MakeRos2Message(const void* descriptor, std::size_t size) {
  return {.descriptor = descriptor, .size = size, .as_is = &internal::TypeInfoOf<T>()};
}

template <ros2::Message T>
struct DdsMessageOf<T> {
  static const DdsMessage& Get() {
    static const DdsMessage kMessage = internal::MakeShippedRos2Message(internal::TypeInfoOf<T>());
    return kMessage;
  }
};

struct DdsPublisherParams {
  std::string topic = "";  ///< name of the topic, such as "rt/lowstate"; in ROS 2 that is "/lowstate"
  DdsLink link = {};
  Rate rate = Hz(100);
  bool lock_step =
      false;      ///< the receiver has lock_step; messages carry the time of the run, and none is lost
  int depth = 0;  ///< messages kept for readers that lag behind; 0: 10 for a message of ROS 2, else 1
  bool transient_local = false;  ///< readers that join later receive the kept messages, too
  bool silent = false;           ///< does not join DDS and sends nothing, as in the replay of a run
};

template <class T>
struct DdsInputParams {
  static constexpr double kForever = std::numeric_limits<double>::infinity();
  std::string topic = "";  ///< name of the topic, such as "rt/lowcmd"
  DdsLink link = {};
  T initial = internal::Zeroed<T>();  ///< y until the first message
  Rate rate = Hz(1000);               ///< rate at which y takes over messages
  bool lock_step = false;             ///< each tick waits for the message with its time
  double timeout_s = 10;              ///< timeout of lock-step [s of wall-clock time]
  double valid_s = kForever;          ///< y is `expired` this time after the last message
  T expired = internal::Zeroed<T>();  ///< value of y then
  bool record = false;                ///< records the values and the times at which y took them over
  Recording<T> replay = {};           ///< if not empty, y follows this recording and does not join DDS
};

/// Sends a signal by DDS as one message per sample. T needs a DdsMessageOf.
///
///     builder.Connect(robot.state, builder.Add<DdsPublisher<UnitreeState>>(
///         "to_client", {.topic = "rt/lowstate", .link = {.domain = 1, .interface = "lo"}}).u);
///
/// The writer is reliable and keeps the last message, as is the default of DDS, or the last ten messages of
/// ROS 2, as is the default there; readers may be reliable or not, and none is required. `unsent` counts the
/// messages that Cyclone DDS refused. Only the first message allocates, apart from Cyclone DDS itself. Throws
/// ParameterError if the domain cannot be joined or the topic has another type.
template <class T>
class DdsPublisher final : public LeafSystem<DdsPublisherParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPort<T> u{this, "u"};
  Scratch<std::uint64_t> unsent{this, "unsent"};
  Workspace<std::vector<char>> message{this, "message"};
  Publish send{this, "send", Sampled{params.rate}, Uses(time, u, unsent, message), &DdsPublisher::Send};

 private:
  void Send(double t, const T& value, std::uint64_t& lost, std::vector<char>& bytes) const {
    if (sender_ && !sender_->Send(t, &value, bytes)) ++lost;
  }
  std::unique_ptr<internal::DdsSender> sender_ =
      params.silent ? nullptr
                    : internal::MakeDdsSender(
                          {params.topic, params.link, params.lock_step, params.depth, params.transient_local},
                          DdsMessageOf<T>::Get());
};

/// An input for values that DdsPublisher or another program sends by DDS. T needs a DdsMessageOf.
///
///     auto& command = builder.Add<DdsInput<UnitreeCommand>>("command", {.topic = "rt/lowcmd"});
///
/// At each tick, y takes over the last message and holds it until the next tick, also that of a sender that
/// has ended, unless `valid_s` is given. The block has no thread: Cyclone DDS receives, and keeps the last 64
/// messages until the tick. With `lock_step`, a tick waits for the message with its own time, as UdpInput
/// does; the two programs can start in any order. Recording and replay work as in ExternalInput.
///
/// Received messages are not trusted. A refused one leaves y as it is; `context.Eval(command.refused)`
/// returns the number of refusals and the last reason:
/// - the mapping refuses a message, for example because of a wrong checksum;
/// - a number is not finite;
/// - the size or layout is not that of the type, or a sender offers another type under the topic's name;
/// - a sender's clock goes back: a message is older than the last one of the same sender;
/// - a list of a message of ROS 2 has another length than in `initial`.
///
/// The reader is not reliable, so that it hears all senders.
///
/// Throws ParameterError if the domain cannot be joined or the topic has another type. In lock-step, throws
/// RunError if the message of a tick is late.
template <class T>
class DdsInput final : public LeafSystem<DdsInputParams<T>> {
  using Base = LeafSystem<DdsInputParams<T>>;

 public:
  using Base::Base;
  using Base::params;

  Scratch<TakenOver<T>> taken{this, "taken", {params.initial, 0, {}}};
  Scratch<RefusedMessages> refused{this, "refused"};
  Scratch<double> taken_time{this, "taken_time", DdsInputParams<T>::kForever};  ///< of the last message [s]
  ExternalPort<T> y{this,
                    "y",
                    params.initial,
                    Sampled{params.rate},
                    Uses(this->time, taken, refused, taken_time),
                    &DdsInput::TakeOver};
  /// Time of the last message by its sender's clock [s]; 0 before the first.
  double sent() const { return inbox_ ? inbox_->sent() : 0; }

 private:
  void TakeOver(double t, TakenOver<T>& taken_now, RefusedMessages& refused_now, double& taken_at,
                T* y_out) const {
    const std::uint64_t before = taken_now.number;
    internal::TakeOver(params, inbox_.get(), t, taken_now, refused_now);
    if (taken_now.number != before) taken_at = t;
    const bool expired = t - taken_at > params.valid_s - params.rate.period() / 2;
    *y_out = expired ? params.expired : taken_now.value;
  }

  std::unique_ptr<internal::Inbox> Open() {
    if (!params.replay.empty()) return nullptr;
    return internal::MakeDdsInbox({params.topic, params.link, params.lock_step}, DdsMessageOf<T>::Get(),
                                  params.timeout_s);
  }
  std::unique_ptr<internal::Inbox> inbox_ = Open();
};

}  // namespace tenon
