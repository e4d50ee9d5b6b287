#include <tenon/systems/io/internal/no_signals.h>
#include <tenon/systems/network/udp.h>

#include <fmt/core.h>
#include <netdb.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <list>
#include <system_error>
#include <thread>

namespace tenon::internal {

namespace {

/// Returns the remedy for an error of bind().
const char* RemedyFor(int error) {
  if (error == EADDRINUSE) return "choose another port, 0 for any, or end the program that uses it";
  if (error == EADDRNOTAVAIL)
    return "give an address of this machine: 127.0.0.1, or 0.0.0.0 for all of its addresses";
  return "choose another port, 0 for any, or another address";
}

}  // namespace

/// A UDP socket.
class UdpSocket {
 public:
  static constexpr std::size_t kLargestDatagram = 65507;  ///< [bytes], of IPv4
  enum class Use { kSend, kReceive };
  /// Binds to the address for receiving, or connects to it for sending. Throws ParameterError if the address
  /// does not exist or the port is in use.
  UdpSocket(Use use, const std::string& address, int port) : port_(port) {
    const int lowest = use == Use::kSend ? 1 : 0;
    Demand(port >= lowest && port <= 65535, fmt::format("port = {} must be {} to 65535", port, lowest));
    const std::string service = std::to_string(port);
    name_ = address.find(':') == std::string::npos ? fmt::format("{}:{}", address, port)
                                                   : fmt::format("[{}]:{}", address, port);
    addrinfo hints{};
    hints.ai_socktype = SOCK_DGRAM;
    addrinfo* list = nullptr;
    if (const int error = getaddrinfo(address.c_str(), service.c_str(), &hints, &list); error != 0) {
      throw ParameterError(
          fmt::format("address = '{}', port {}: {}; give an address such as 127.0.0.1 or ::1, or "
                      "the name of a host",
                      address, port, gai_strerror(error)));
    }
    const std::unique_ptr<addrinfo, void (*)(addrinfo*)> found(list, freeaddrinfo);
    address_size_ = found->ai_addrlen;
    std::memcpy(&address_, found->ai_addr, address_size_);
    file_ = socket(found->ai_family, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    if (file_ < 0) throw RunError(fmt::format("no socket for {}: {}", name_, std::strerror(errno)));
    if (use == Use::kSend) {
      const int yes = 1;
      setsockopt(file_, SOL_SOCKET, SO_BROADCAST, &yes, sizeof yes);
      return;
    }
    auto* bound = reinterpret_cast<sockaddr*>(&address_);
    if (bind(file_, bound, address_size_) != 0) {
      const int error = errno;
      close(file_);
      throw ParameterError(
          fmt::format("cannot receive at {}: {}; {}", name_, std::strerror(error), RemedyFor(error)));
    }
    if (port != 0) return;
    getsockname(file_, bound, &address_size_);
    port_ = ntohs(address_.ss_family == AF_INET6 ? reinterpret_cast<sockaddr_in6*>(bound)->sin6_port
                                                 : reinterpret_cast<sockaddr_in*>(bound)->sin_port);
    name_.replace(name_.size() - 1, 1, std::to_string(port_));
  }
  ~UdpSocket() { close(file_); }
  UdpSocket(const UdpSocket&) = delete;
  UdpSocket& operator=(const UdpSocket&) = delete;

  /// Address and actual port: "127.0.0.1:9870".
  const std::string& name() const { return name_; }
  int port() const { return port_; }
  int file() const { return file_; }  ///< file descriptor, to wait for a datagram
  /// Sends without waiting. Returns false if the system refuses the datagram, because its buffers are full or
  /// the network is down.
  bool Send(std::span<const char> message) const {
    const auto* to = reinterpret_cast<const sockaddr*>(&address_);
    return sendto(file_, message.data(), message.size(), MSG_DONTWAIT | MSG_NOSIGNAL, to, address_size_) >= 0;
  }
  /// Waits for a datagram; empty at the timeout [s]. The result is valid until the next call.
  std::optional<std::span<const char>> Receive(double timeout_s) {
    using Clock = std::chrono::steady_clock;
    const auto end = Clock::now() + std::chrono::duration<double>(timeout_s);
    received_.resize(kLargestDatagram);
    for (;;) {
      const ssize_t size = recv(file_, received_.data(), received_.size(), MSG_DONTWAIT);
      if (size >= 0) return std::span<const char>(received_.data(), static_cast<std::size_t>(size));
      const std::chrono::duration<double> left = end - Clock::now();
      if (left.count() <= 0) return {};
      pollfd ready{file_, POLLIN, 0};
      poll(&ready, 1, static_cast<int>(std::min(1e6, std::ceil(1e3 * left.count()))));
    }
  }

 private:
  int file_ = -1;
  int port_;
  sockaddr_storage address_{};
  socklen_t address_size_ = 0;
  std::string name_;
  std::vector<char> received_;
};

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
