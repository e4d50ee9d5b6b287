#include <tenon/systems/block.h>
#include <tenon/systems/network/internal/udp_socket.h>

#include <fmt/core.h>
#include <netdb.h>
#include <netinet/in.h>
#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>

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

UdpSocket::UdpSocket(Use use, const std::string& address, int port) : port_(port) {
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

UdpSocket::~UdpSocket() {
  close(file_);
}

bool UdpSocket::Send(std::span<const char> message) const {
  const auto* to = reinterpret_cast<const sockaddr*>(&address_);
  return sendto(file_, message.data(), message.size(), MSG_DONTWAIT | MSG_NOSIGNAL, to, address_size_) >= 0;
}

std::optional<std::span<const char>> UdpSocket::Receive(double timeout_s) {
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

}  // namespace tenon::internal
