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

/// A connection to an LCM network. All blocks of a program that name the same URL share one.
class LcmBus {
  struct Mail;

 public:
  /// Throws ParameterError if LCM does not open it.
  static std::shared_ptr<LcmBus> Open(const std::string& url);
  explicit LcmBus(const std::string& url);
  ~LcmBus();
  LcmBus(const LcmBus&) = delete;
  LcmBus& operator=(const LcmBus&) = delete;

  /// False if LCM does not take it.
  bool Publish(const std::string& channel, std::span<const char> message);

  /// Takes what comes on a channel.
  class Subscription {
   public:
    /// With `on_demand`, messages stay in LCM until Take asks for them; else a thread collects them all the
    /// time. Throws ParameterError if LCM does not subscribe.
    Subscription(std::shared_ptr<LcmBus> bus, const std::string& channel, bool on_demand);
    ~Subscription();
    Subscription(const Subscription&) = delete;
    Subscription& operator=(const Subscription&) = delete;
    /// Waits for a message as long [s]; false if none comes.
    bool Take(double timeout_s, std::vector<char>& message);
    /// All messages that have come and were not taken, in their order.
    std::deque<std::vector<char>> TakeAll();

   private:
    const std::shared_ptr<LcmBus> bus_;
    Mail* mail_;
    lcm_subscription_t* subscription_;
  };

 private:
  /// What has come to a subscription and was not yet taken. Another thread may be about to put something in
  /// while the subscription ends: so it lives as long as the bus.
  struct Mail {
    LcmBus* bus;
    bool open = true;
    std::deque<std::vector<char>> messages = {};
  };
  /// Called by HandleNext alone.
  static void Handle(const lcm_recv_buf_t* received, const char* channel, void* mail);
  /// Puts the next message that is queued in LCM into its mail; needs `mutex_`. As lcm_handle_timeout,
  /// returns 0 if there is none and less if none can come any more.
  int HandleNext() { return lcm_handle_timeout(lcm_, 0); }
  int HandleAll();
  /// Wakes all that wait for messages.
  void Notify();

  const std::string url_;
  lcm_t* lcm_;
  std::mutex mutex_;  ///< of what follows, and held while LCM hands out messages
  std::condition_variable came_;
  std::list<Mail> mails_;
  bool waiting_ = false;  ///< some thread waits for LCM, for all
  int nudge_ = -1;        ///< a file descriptor that wakes that thread
  std::optional<Watcher> watcher_;
};

}  // namespace tenon::internal
