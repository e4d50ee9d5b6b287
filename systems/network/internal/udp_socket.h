#pragma once

#include <sys/socket.h>

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace tenon::internal {

/// A UDP socket.
class UdpSocket {
 public:
  static constexpr std::size_t kLargestDatagram = 65507;  ///< [bytes], of IPv4
  enum class Use { kSend, kReceive };
  /// Binds to the address for receiving, or connects to it for sending. Throws ParameterError if the address
  /// does not exist or the port is in use.
  UdpSocket(Use use, const std::string& address, int port);
  ~UdpSocket();
  UdpSocket(const UdpSocket&) = delete;
  UdpSocket& operator=(const UdpSocket&) = delete;

  /// Address and actual port: "127.0.0.1:9870".
  const std::string& name() const { return name_; }
  int port() const { return port_; }
  int file() const { return file_; }  ///< file descriptor, to wait for a datagram
  /// Sends without waiting. Returns false if the system refuses the datagram, because its buffers are full or
  /// the network is down.
  bool Send(std::span<const char> message) const;
  /// Waits for a datagram; empty at the timeout [s]. The result is valid until the next call.
  std::optional<std::span<const char>> Receive(double timeout_s);

 private:
  int file_ = -1;
  int port_;
  sockaddr_storage address_{};
  socklen_t address_size_ = 0;
  std::string name_;
  std::vector<char> received_;
};

}  // namespace tenon::internal
