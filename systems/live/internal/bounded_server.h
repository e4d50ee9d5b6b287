#pragma once

#include <httplib.h>

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <list>
#include <mutex>

namespace tenon::internal {

/// A server of httplib that stays available whatever its clients do. It has a limited number of connections,
/// with one request and one thread each. If all are in use, a new connection ends the oldest one whose
/// request is still incomplete. A request must arrive within 5 s, and its answer must be read within 30 s,
/// however slowly the client sends and reads.
class BoundedServer : public httplib::Server {
 public:
  /// Uses at most 64 connections and at most a quarter of the descriptors that the process may open.
  BoundedServer();

  /// Marks the request of this thread as complete. For handlers.
  void Received();
  /// Removes the limit of the time to read the answer. Returns false if half of the connections have done so.
  /// For handlers.
  bool BeginStream();
  /// Ends incomplete requests, and waits until the other connections have ended. Call it after stop(); the
  /// destructor may run only after it.
  void EndConnections();

 private:
  using Clock = std::chrono::steady_clock;
  enum class State { kReceiving, kAnswering, kStreaming };
  struct Connection {
    int socket;
    Clock::time_point begin = Clock::now();
    State state = State::kReceiving;
  };
  class Socket;

  bool process_and_close_socket(int socket) override;  // called by the listening thread
  bool MakeRoom(std::unique_lock<std::mutex>& lock);
  void Serve(std::list<Connection>::iterator connection);

  static thread_local Connection* current_;  // of this thread
  const std::size_t max_;
  std::mutex mutex_;
  std::condition_variable ended_;  // a connection has ended
  std::list<Connection> connections_;
};

}  // namespace tenon::internal
