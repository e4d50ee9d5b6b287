#pragma once

#include <lcm/lcm.h>

#include <condition_variable>
#include <deque>
#include <list>
#include <memory>
#include <mutex>
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
    /// Throws ParameterError if LCM does not subscribe.
    Subscription(std::shared_ptr<LcmBus> bus, const std::string& channel);
    ~Subscription();
    Subscription(const Subscription&) = delete;
    Subscription& operator=(const Subscription&) = delete;
    /// Waits for a message as long [s]; false if none comes.
    bool Take(double timeout_s, std::vector<char>& message);

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
  static void Handle(const lcm_recv_buf_t* received, const char* channel, void* mail);

  const std::string url_;
  lcm_t* lcm_;
  std::mutex mutex_;
  std::condition_variable came_;
  std::list<Mail> mails_;
  bool handling_ = false;  ///< some thread waits inside of LCM, for all
};

}  // namespace tenon::internal
