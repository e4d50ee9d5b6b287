#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

namespace tenon::internal {

/// An HTTP answer to a command.
struct LiveReply {
  int status = 200;
  std::string json = R"({"ok":true})";
};
LiveReply Refusal(int status, const std::string& why);

/// A command of a browser that waits for the answer of the run.
struct LiveRequest {
  std::string client;
  std::string json;
  std::promise<LiveReply> reply;
};

/// Exchanges messages between the thread of the run and the threads of the server. The run never waits for a
/// browser: messages go into a bounded history that browsers read at their own pace; a browser that is too
/// slow starts over.
class LiveChannel {
 public:
  explicit LiveChannel(double history) : history_(history) {}

  // For the thread of the run.

  /// Begins a run with its description. The first append to each reader contains `names`.
  void Begin(std::string hello, std::string names);
  /// Adds an append message at `time` [s], given without braces and names.
  void Append(double time, std::string body);
  /// Adds another kind of message in order.
  void Say(double time, const std::string& event, const std::string& json);
  /// Clears the history and notifies the readers.
  void Clear();
  /// Sets messages of which readers need only the last one.
  void SetStatus(std::string json);
  void SetPull(std::string json);
  std::optional<LiveRequest> TakeRequest();
  /// Waits for a request, at most until the given time.
  void WaitUntil(std::chrono::steady_clock::time_point time);
  std::size_t clients() const;
  bool IsConnected(const std::string& client) const;
  void CountRefused();
  long refused() const;
  /// Ends all waiting calls.
  void Close();

  // For the threads of the server.

  LiveReply Ask(const std::string& client, std::string json);

  /// A stream of events to one browser.
  class Reader {
   public:
    /// Does not throw; `admitted` returns whether the number of streams is within its limit.
    Reader(LiveChannel& channel, std::string client);
    ~Reader();
    Reader(const Reader&) = delete;
    Reader& operator=(const Reader&) = delete;
    bool admitted() const { return admitted_; }
    /// Returns the next messages as Server-Sent Events, a comment after a while without messages, or an empty
    /// text at the end of the server.
    std::string Next();

   private:
    LiveChannel& channel_;
    std::string client_;
    bool admitted_ = false, named_ = false;
    std::uint64_t hello_ = 0, status_ = 0, pull_ = 0, next_ = 0;
  };

 private:
  struct Message {
    double time;
    bool append;
    std::string text;
  };
  struct Latest {
    std::uint64_t version = 0;
    std::string text;
  };
  void Push(Message message);
  void Set(Latest& latest, std::string text);

  const double history_;  // length of the history [s]
  mutable std::mutex mutex_;
  std::condition_variable news_, asked_;
  bool closed_ = false;
  Latest hello_, status_, pull_;
  std::string names_;
  std::deque<Message> messages_;
  std::uint64_t first_ = 0;  // number of the first message in the history
  std::size_t bytes_ = 0;    // size of the history
  std::deque<LiveRequest> requests_;
  std::map<std::string, int> streams_;  // number of streams of each client
  std::size_t num_streams_ = 0;
  long refused_ = 0;
};

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
