#pragma once

#include <sys/socket.h>

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace tenon::internal {

/// A socket for datagrams.
class UdpSocket {
 public:
  static constexpr std::size_t kLargestDatagram = 65507;  ///< [bytes], of IPv4
  enum class Use { kSend, kReceive };
  /// Binds to the address, or sends there. Throws ParameterError if there is no such address, or the port is
  /// taken.
  UdpSocket(Use use, const std::string& address, int port);
  ~UdpSocket();
  UdpSocket(const UdpSocket&) = delete;
  UdpSocket& operator=(const UdpSocket&) = delete;

  /// "127.0.0.1:9870", the port being the one that the system has chosen if it was 0.
  const std::string& name() const { return name_; }
  int port() const { return port_; }
  int file() const { return file_; }  ///< to wait for a datagram
  /// Without waiting; false if the system does not take the datagram: its buffers are full, the network is
  /// down.
  bool Send(std::span<const char> message) const;
  /// Waits for a datagram as long [s]; nothing if none comes. It lies in the socket until the next.
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
