#pragma once

#include <tenon/systems/network/internal/watcher.h>

#include <lcm/lcm.h>

#include <condition_variable>
#include <deque>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace tenon::internal {

/// A connection to an LCM network, shared by all blocks of a program with the same URL.
class LcmBus {
  struct Mail;

 public:
  /// Throws ParameterError if LCM cannot open the URL.
  static std::shared_ptr<LcmBus> Open(const std::string& url);
  explicit LcmBus(const std::string& url);
  ~LcmBus();
  LcmBus(const LcmBus&) = delete;
  LcmBus& operator=(const LcmBus&) = delete;

  /// Returns false if LCM refuses the message.
  bool Publish(const std::string& channel, std::span<const char> message);

  /// A subscription of a channel.
  class Subscription {
   public:
    /// With `on_demand`, messages stay in LCM's queue until Take requests them; else a thread collects them
    /// continuously. Throws ParameterError if LCM refuses the subscription.
    Subscription(std::shared_ptr<LcmBus> bus, const std::string& channel, bool on_demand);
    ~Subscription();
    Subscription(const Subscription&) = delete;
    Subscription& operator=(const Subscription&) = delete;
    /// Waits for a message; returns false at the timeout [s].
    bool Take(double timeout_s, std::vector<char>& message);
    /// Removes and returns all received messages in order.
    std::deque<std::vector<char>> TakeAll();

   private:
    const std::shared_ptr<LcmBus> bus_;
    Mail* mail_;
    lcm_subscription_t* subscription_;
  };

 private:
  /// Received messages of a subscription. It lives as long as the bus, because another thread may add
  /// messages while the subscription ends.
  struct Mail {
    LcmBus* bus;
    bool open = true;
    std::deque<std::vector<char>> messages = {};
  };
  /// Called only by HandleNext.
  static void Handle(const lcm_recv_buf_t* received, const char* channel, void* mail);
  /// Moves the next message of LCM's queue to its subscription; requires `mutex_`. Returns 0 if there is none
  /// and a negative number if there can be no more, as lcm_handle_timeout does.
  int HandleNext() { return lcm_handle_timeout(lcm_, 0); }
  int HandleAll();
  /// Wakes all threads that wait for messages.
  void Notify();

  const std::string url_;
  lcm_t* lcm_;
  std::mutex mutex_;  ///< protects the members below; locked while LCM handles messages
  std::condition_variable came_;
  std::list<Mail> mails_;
  bool waiting_ = false;  ///< one thread waits for LCM on behalf of all
  int nudge_ = -1;        ///< file descriptor that wakes the waiting thread
  std::optional<Watcher> watcher_;
};

}  // namespace tenon::internal
