#include <tenon/systems/io/internal/no_signals.h>
#include <tenon/systems/network/internal/udp_socket.h>
#include <tenon/systems/network/udp.h>

#include <fmt/core.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <list>
#include <system_error>
#include <thread>

namespace tenon::internal {
namespace {

void CheckHasNumbers(const TypeInfo& type) {
  using Kind = TypeInfo::Kind;
  const bool none = type.kind == Kind::kOpaque || type.kind == Kind::kMap || type.kind == Kind::kText ||
                    (type.fixed && type.num_scalars == 0);
  Demand(!none, fmt::format("{} holds no numbers to send: give it a static Fields()", TypeName(type)));
}

/// Returns the spec of the nearest upstream source that names its elements, else of the port itself.
const Spec& NamingSpec(const Source& port) {
  for (const Source* source = &port; source != nullptr; source = source->driver()) {
    if (!source->spec().elements.empty()) return source->spec();
  }
  return port.spec();
}

class UdpInbox final : public Inbox {
 public:
  UdpInbox(const UdpReception& reception, const TypeInfo& type, const void* model)
      : Inbox(reception.reception),
        lock_step_(reception.reception.lock_step),
        name_(reception.name),
        reader_(reception.name, type, model, reception.spec),
        socket_(UdpSocket::Use::kReceive, reception.address, reception.port) {
    if (lock_step_) return;
    try {
      const NoSignals no_signals;
      thread_ = std::jthread([this](const std::stop_token& stop) { CollectUntil(stop); });
    } catch (const std::system_error&) {
      // The system has no thread left, so the socket is emptied at the ticks.
    }
  }
  int port() const { return socket_.port(); }

 private:
  void CollectUntil(const std::stop_token& stop) {
    const int woken = eventfd(0, EFD_CLOEXEC), longest = woken < 0 ? 10 : -1;  // [ms]
    {
      const std::stop_callback wake(stop, [woken] { eventfd_write(woken, 1); });
      std::array<pollfd, 2> files{pollfd{socket_.file(), POLLIN, 0}, pollfd{woken, POLLIN, 0}};
      while (!stop.stop_requested())
        if (poll(files.data(), files.size(), longest) > 0) Collect();
    }
    close(woken);
  }
  /// Empties the socket, because the system drops new datagrams while its buffer is full.
  void Collect() {
    const std::lock_guard lock(mutex_);
    for (std::size_t i = 0; i < kMostMessages; ++i) {  // bounded, because a sender may be faster
      const auto message = socket_.Receive(0);
      if (!message) return;
      if (messages_.size() == kMostMessages) messages_.pop_front();
      messages_.emplace_back(message->begin(), message->end());
    }
  }
  std::optional<std::span<const char>> Receive(double timeout_s) override {
    if (lock_step_) return socket_.Receive(timeout_s);
    Collect();
    const std::lock_guard lock(mutex_);
    if (messages_.empty()) return {};
    message_ = std::move(messages_.front());
    messages_.pop_front();
    return message_;
  }
  std::string Read(std::span<const char> message, double* timestamp, void* value) override {
    return reader_.Read(message, timestamp, value);
  }
  std::string Description() const override {
    return fmt::format("signal '{}' at UDP {}", name_, socket_.name());
  }

  const bool lock_step_;
  const std::string name_;
  JsonReader reader_;
  UdpSocket socket_;
  std::mutex mutex_;                       ///< protects messages_ and, without lock-step, the socket
  std::list<std::vector<char>> messages_;  ///< which allocates nothing while it is empty
  std::vector<char> message_;              ///< last received message
  std::jthread thread_;
};

}  // namespace

void CheckSignalName(const std::string& name) {
  Demand(!name.empty(), "name is empty: set the name of the signal in the messages");
  Demand(name != kJsonTimestamp,
         fmt::format("name = '{}' is reserved for the time: choose another name", name));
}

UdpSender::UdpSender(const std::string& name, const std::string& address, int port, const TypeInfo& type)
    : name_(name), socket_(std::make_unique<UdpSocket>(UdpSocket::Use::kSend, address, port)) {
  CheckHasNumbers(type);
}

UdpSender::~UdpSender() = default;

bool UdpSender::Send(double time, const Source& port, const void* value, JsonWriter& writer) const {
  const std::span<const char> message = writer.Write(time, name_, port.type(), value, NamingSpec(port));
  if (message.size() > UdpSocket::kLargestDatagram) {
    throw RunError(fmt::format(
        "a message of signal '{}' has {} bytes, but a datagram holds at most {}: send parts of the "
        "signal by several publishers",
        name_, message.size(), UdpSocket::kLargestDatagram));
  }
  return socket_->Send(message);
}

std::unique_ptr<Inbox> MakeUdpInbox(const UdpReception& reception, const TypeInfo& type, const void* model,
                                    int* port) {
  CheckHasNumbers(type);
  auto inbox = std::make_unique<UdpInbox>(reception, type, model);
  *port = inbox->port();
  return inbox;
}

}  // namespace tenon::internal
