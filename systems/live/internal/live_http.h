#pragma once

#include <memory>
#include <string>

namespace tenon::internal {

class LiveChannel;

/// The HTTP server: the page, the events, the commands. It has threads of its own and knows nothing of the
/// run but its channel.
class LiveHttp {
 public:
  /// Listens at `port` or one of the next twenty; 0: any. Throws OutputError that says what is wrong with the
  /// address or the ports.
  LiveHttp(const std::string& address, int port, LiveChannel& channel);
  ~LiveHttp();  ///< closes the channel too
  LiveHttp(const LiveHttp&) = delete;
  LiveHttp& operator=(const LiveHttp&) = delete;

  void SetPage(std::string html);
  const std::string& url() const;
  const std::string& token() const;  ///< empty on this machine alone
  int port() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tenon::internal
