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

/// An answer to a command, as HTTP has it.
struct LiveReply {
  int status = 200;
  std::string json = R"({"ok":true})";
};
LiveReply Refusal(int status, const std::string& why);

/// What a browser asks for, until the run has answered.
struct LiveRequest {
  std::string client;
  std::string json;
  std::promise<LiveReply> reply;
};

/// Stands between the thread of the run and those of the server. The run never waits for a browser: messages
/// go into one bounded history that all read at their own pace, and who falls behind it begins anew.
class LiveChannel {
 public:
  explicit LiveChannel(double history) : history_(history) {}

  // The run's side.

  /// A run begins: what describes it. `names` stands in the first append that a reader gets.
  void Begin(std::string hello, std::string names);
  /// An append at `time` [s], without its braces and names.
  void Append(double time, std::string body);
  /// Any other message that comes in its order.
  void Say(double time, const std::string& event, const std::string& json);
  /// Forgets the history; readers are told.
  void Clear();
  /// Messages of which only the last counts.
  void SetStatus(std::string json);
  void SetPull(std::string json);
  std::optional<LiveRequest> TakeRequest();
  /// Until there is a request, or the time has come.
  void WaitUntil(std::chrono::steady_clock::time_point time);
  std::size_t clients() const;
  bool IsConnected(const std::string& client) const;
  void CountRefused();
  long refused() const;
  /// Everything that waits returns.
  void Close();

  // The server's side.

  LiveReply Ask(const std::string& client, std::string json);

  /// One stream of events.
  class Reader {
   public:
    /// Throws nothing; `admitted` says whether there is room for one more.
    Reader(LiveChannel& channel, std::string client);
    ~Reader();
    Reader(const Reader&) = delete;
    Reader& operator=(const Reader&) = delete;
    bool admitted() const { return admitted_; }
    /// What comes next, as Server-Sent Events; a comment if nothing does for a while; empty if the server
    /// ends.
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

  const double history_;  // [s]
  mutable std::mutex mutex_;
  std::condition_variable news_, asked_;
  bool closed_ = false;
  Latest hello_, status_, pull_;
  std::string names_;
  std::deque<Message> messages_;
  std::uint64_t first_ = 0;  // number of the first message that is kept
  std::size_t bytes_ = 0;    // of all that are
  std::deque<LiveRequest> requests_;
  std::map<std::string, int> streams_;  // of each client
  std::size_t num_streams_ = 0;
  long refused_ = 0;
};

}  // namespace tenon::internal
