#pragma once

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <string>

namespace tenon::test {

/// A socket at a port that the system chooses, in the role of another program.
class Peer {
 public:
  Peer() : file_(socket(AF_INET, SOCK_DGRAM, 0)) {
    sockaddr_in address = At(0);
    EXPECT_EQ(bind(file_, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    socklen_t size = sizeof address;
    getsockname(file_, reinterpret_cast<sockaddr*>(&address), &size);
    port_ = ntohs(address.sin_port);
    const timeval ten_seconds{10, 0};
    setsockopt(file_, SOL_SOCKET, SO_RCVTIMEO, &ten_seconds, sizeof ten_seconds);
  }
  ~Peer() { close(file_); }
  Peer(const Peer&) = delete;
  Peer& operator=(const Peer&) = delete;

  int port() const { return port_; }
  /// The next datagram; "" after 10 s without.
  std::string Receive() const {
    std::string text(65536, '\0');
    const ssize_t size = recv(file_, text.data(), text.size(), 0);
    text.resize(size < 0 ? 0 : static_cast<std::size_t>(size));
    return text;
  }
  bool HasNothing() const {
    char byte;
    return recv(file_, &byte, 1, MSG_DONTWAIT) < 0;
  }
  /// Sends to a port of this machine. On return, the text is in the queue of the receiver.
  void Send(int port, const std::string& text) const {
    const sockaddr_in to = At(port);
    EXPECT_EQ(sendto(file_, text.data(), text.size(), 0, reinterpret_cast<const sockaddr*>(&to), sizeof to),
              static_cast<ssize_t>(text.size()));
  }

 private:
  static sockaddr_in At(int port) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    return address;
  }
  int file_;
  int port_ = 0;
};

}  // namespace tenon::test
