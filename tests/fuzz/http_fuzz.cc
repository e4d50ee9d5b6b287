// Bytes as a request to the server of a live page, which must serve its page afterwards.

#include <tenon/systems/live/internal/live_channel.h>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdlib>
#include <string_view>
#include <thread>

namespace {

/// A server whose run answers every command.
struct Server {
  Server() : http("127.0.0.1", 0, channel), run([this] { Answer(); }) { http.SetPage("page"); }
  ~Server() {
    stop = true;
    run.join();
  }
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  void Answer() {
    while (!stop) {
      channel.WaitUntil(std::chrono::steady_clock::now() + std::chrono::milliseconds(20));
      while (auto request = channel.TakeRequest()) request->reply.set_value({200, "{}"});
    }
  }
  /// Sends a request and returns the beginning of the answer.
  std::string Exchange(std::string_view request) const {
    const int link = ::socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(static_cast<std::uint16_t>(http.port()));
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    std::array<char, 4096> answer{};
    ::ssize_t size = 0;
    if (::connect(link, reinterpret_cast<sockaddr*>(&to), sizeof(to)) == 0) {
      ::send(link, request.data(), request.size(), MSG_NOSIGNAL);
      ::shutdown(link, SHUT_WR);
      size = ::recv(link, answer.data(), answer.size(), 0);
    }
    ::close(link);
    return {answer.data(), size > 0 ? static_cast<std::size_t>(size) : 0};
  }

  tenon::internal::LiveChannel channel{10};
  tenon::internal::LiveHttp http;
  std::atomic<bool> stop = false;
  std::thread run;
};

}  // namespace

// The text PORT stands for the port of the server, as in the header Host.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const Server kServer;
  static int count = 0;
  const std::string port = std::to_string(kServer.http.port());
  std::string request(reinterpret_cast<const char*>(data), size);
  for (std::size_t at = 0; (at = request.find("PORT", at)) != request.npos; at += port.size())
    request.replace(at, 4, port);
  kServer.Exchange(request);
  if (++count % 100 == 0 &&
      kServer.Exchange("GET / HTTP/1.1\r\nHost: 127.0.0.1:" + port + "\r\n\r\n").find(" 200 ") ==
          std::string::npos)
    std::abort();
  return 0;
}
