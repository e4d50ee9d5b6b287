#pragma once

#include <memory>
#include <string>

namespace tenon::internal {

class LiveChannel;

/// The HTTP server of the page, the events and the commands. It has its own threads and accesses the run only
/// through the channel.
class LiveHttp {
 public:
  /// Listens at `port` or one of the next twenty, or at any port for 0. Throws OutputError if that is
  /// impossible.
  LiveHttp(const std::string& address, int port, LiveChannel& channel);
  ~LiveHttp();  ///< closes the channel
  LiveHttp(const LiveHttp&) = delete;
  LiveHttp& operator=(const LiveHttp&) = delete;

  void SetPage(std::string html);
  const std::string& url() const;
  const std::string& token() const;  ///< empty if only this machine has access
  int port() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tenon::internal
