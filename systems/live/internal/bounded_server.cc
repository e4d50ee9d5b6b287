#include <tenon/systems/live/internal/bounded_server.h>

#include <poll.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <exception>
#include <functional>
#include <string>
#include <thread>
#include <utility>

namespace tenon::internal {
namespace {

constexpr std::size_t kMostConnections = 64, kFewestConnections = 8;
constexpr std::chrono::seconds kRequestWithin(5);  // from the begin of the connection
constexpr std::chrono::seconds kAnswerWithin(30);  // from the begin of the connection
constexpr std::chrono::seconds kWriteWithin(5);    // timeout for a client that does not read
constexpr std::chrono::seconds kLeaveWithin(2);    // timeout for a connection that is ended
constexpr std::size_t kMaxRequest = 1 << 18;       // maximal size of a request with its headers [bytes]

std::size_t MaxConnections() {
  ::rlimit limit{};
  if (::getrlimit(RLIMIT_NOFILE, &limit) != 0) return kFewestConnections;
  return std::clamp(static_cast<std::size_t>(limit.rlim_cur) / 4, kFewestConnections, kMostConnections);
}

/// Executes tasks in the listening thread, which only hands the connections to their own threads.
class Inline : public httplib::TaskQueue {
 public:
  // Newer versions of httplib return whether the task was accepted.
  using Accepted = decltype(std::declval<httplib::TaskQueue&>().enqueue({}));
  Accepted enqueue(std::function<void()> task) override {
    task();
    return Accepted(true);
  }
  void shutdown() override {}
};

}  // namespace

/// The stream of one connection, with the limits of time.
class BoundedServer::Socket : public httplib::Stream {
 public:
  explicit Socket(const Connection& connection) : connection_(connection) {}

  bool is_readable() const override { return begin_ < end_ || Wait(POLLIN, kRequestWithin); }
  bool is_writable() const override { return Wait(POLLOUT, kAnswerWithin); }
  ssize_t read(char* to, std::size_t size) override {
    if (begin_ == end_) {
      if (received_ > kMaxRequest || !Wait(POLLIN, kRequestWithin)) return -1;
      const ssize_t got = ::recv(connection_.socket, buffer_.data(), buffer_.size(), 0);
      if (got <= 0) return got;
      begin_ = 0;
      end_ = static_cast<std::size_t>(got);
      received_ += end_;
    }
    const std::size_t count = std::min(size, end_ - begin_);
    std::copy_n(buffer_.data() + begin_, count, to);
    begin_ += count;
    return static_cast<ssize_t>(count);
  }
  ssize_t write(const char* from, std::size_t size) override {
    return Wait(POLLOUT, kAnswerWithin) ? ::send(connection_.socket, from, size, MSG_NOSIGNAL | MSG_DONTWAIT)
                                        : -1;
  }
  void get_remote_ip_and_port(std::string& ip, int& port) const override { ip.clear(), port = 0; }
  void get_local_ip_and_port(std::string& ip, int& port) const override { ip.clear(), port = 0; }
  socket_t socket() const override { return connection_.socket; }

 private:
  /// Waits until the socket is ready, at most until `within` after the begin of the connection.
  bool Wait(short event, Clock::duration within) const {
    Clock::duration left = connection_.begin + within - Clock::now();
    if (event == POLLOUT && connection_.state == State::kStreaming) left = kWriteWithin;
    if (event == POLLOUT) left = std::min<Clock::duration>(left, kWriteWithin);
    if (left <= Clock::duration::zero()) return false;
    ::pollfd wanted{connection_.socket, event, 0};
    const auto milliseconds = std::chrono::ceil<std::chrono::milliseconds>(left).count();
    return ::poll(&wanted, 1, static_cast<int>(milliseconds)) == 1;
  }

  const Connection& connection_;
  std::array<char, 4096> buffer_{};
  std::size_t begin_ = 0, end_ = 0, received_ = 0;
};

thread_local BoundedServer::Connection* BoundedServer::current_ = nullptr;

BoundedServer::BoundedServer() : max_(MaxConnections()) {
  new_task_queue = [] { return new Inline; };
}

void BoundedServer::Received() {
  const std::lock_guard lock(mutex_);
  if (current_ != nullptr && current_->state == State::kReceiving) current_->state = State::kAnswering;
}

bool BoundedServer::BeginStream() {
  const std::lock_guard lock(mutex_);
  const auto streams = [](const Connection& connection) { return connection.state == State::kStreaming; };
  if (std::ranges::count_if(connections_, streams) >= static_cast<std::ptrdiff_t>(max_ / 2)) return false;
  if (current_ != nullptr) current_->state = State::kStreaming;
  return true;
}

/// Returns false if all connections have complete requests.
bool BoundedServer::MakeRoom(std::unique_lock<std::mutex>& lock) {
  if (connections_.size() < max_) return true;
  const auto oldest = std::ranges::find(connections_, State::kReceiving, &Connection::state);
  if (oldest == connections_.end()) return false;
  ::shutdown(oldest->socket, SHUT_RDWR);
  return ended_.wait_for(lock, kLeaveWithin, [&] { return connections_.size() < max_; });
}

bool BoundedServer::process_and_close_socket(int socket) {
  std::unique_lock lock(mutex_);
  if (!MakeRoom(lock)) {
    ::close(socket);
    return false;
  }
  auto connection = connections_.end();
  try {
    connection = connections_.insert(connections_.end(), Connection{.socket = socket});
    std::thread([this, connection] { Serve(connection); }).detach();
  } catch (const std::exception&) {  // the machine has no more threads or memory
    if (connection != connections_.end()) connections_.erase(connection);
    ::close(socket);
  }
  return true;
}

void BoundedServer::Serve(std::list<Connection>::iterator connection) {
  current_ = &*connection;
  Socket stream(*connection);
  bool closed = false;
  // A header of 8 kB could request the page a thousand times in one answer.
  const auto whole = [](httplib::Request& request) { request.ranges.clear(); };
  const auto process = [&](auto& server) {  // the signature depends on the version of httplib
    if constexpr (requires { server.process_request(stream, true, closed, nullptr); }) {
      server.process_request(stream, true, closed, whole);
    } else {
      server.process_request(stream, "", 0, "", 0, true, closed, whole);
    }
  };
  try {
    process(*this);
  } catch (...) {  // such as std::bad_alloc, outside of the handlers; the run goes on
  }
  ::shutdown(connection->socket, SHUT_RDWR);
  const std::lock_guard lock(mutex_);
  ::close(connection->socket);
  connections_.erase(connection);
  ended_.notify_all();
}

void BoundedServer::EndConnections() {
  std::unique_lock lock(mutex_);
  for (const Connection& connection : connections_)
    if (connection.state == State::kReceiving) ::shutdown(connection.socket, SHUT_RDWR);
  if (ended_.wait_for(lock, kLeaveWithin, [this] { return connections_.empty(); })) return;
  for (const Connection& connection : connections_) ::shutdown(connection.socket, SHUT_RDWR);
  ended_.wait(lock, [this] { return connections_.empty(); });
}

}  // namespace tenon::internal
