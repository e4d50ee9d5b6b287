#include <tenon/systems/network/internal/lcm_bus.h>

#include <fmt/core.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <cmath>
#include <map>
#include <utility>

#include <tenon/systems/framework/errors.h>

namespace tenon::internal {
namespace {

/// Of a subscription; who does not take them loses the oldest.
constexpr std::size_t kMostMessages = 4096;

/// LCM takes channels for regular expressions.
std::string Quoted(const std::string& channel) {
  std::string quoted;
  for (const char c : channel) {
    if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '_') quoted += '\\';
    quoted += c;
  }
  return quoted;
}

[[noreturn]] void ThrowNotOpen(const std::string& url) {
  throw ParameterError(fmt::format(
      "url = '{}': LCM does not open it, and says why on stderr; give one such as "
      "udpm://239.255.76.67:7667?ttl=0, or none for LCM's default; these need a route for multicast",
      url));
}

}  // namespace

std::shared_ptr<LcmBus> LcmBus::Open(const std::string& url) {
  static std::mutex mutex;
  static std::map<std::string, std::weak_ptr<LcmBus>> all;
  const std::lock_guard lock(mutex);
  auto bus = all[url].lock();
  if (!bus) all[url] = bus = std::make_shared<LcmBus>(url);
  return bus;
}

LcmBus::LcmBus(const std::string& url) : url_(url), lcm_(lcm_create(url.empty() ? nullptr : url.c_str())) {
  if (lcm_ == nullptr) ThrowNotOpen(url);
}

LcmBus::~LcmBus() {
  lcm_destroy(lcm_);
}

bool LcmBus::Publish(const std::string& channel, std::span<const char> message) {
  return lcm_publish(lcm_, channel.c_str(), message.data(), static_cast<unsigned>(message.size())) == 0;
}

LcmBus::Subscription::Subscription(std::shared_ptr<LcmBus> bus, const std::string& channel)
    : bus_(std::move(bus)) {
  {
    const std::lock_guard lock(bus_->mutex_);
    mail_ = &bus_->mails_.emplace_back(Mail{bus_.get()});
  }
  subscription_ = lcm_subscribe(bus_->lcm_, Quoted(channel).c_str(), &Handle, mail_);
  if (subscription_ == nullptr) ThrowNotOpen(bus_->url_);
  lcm_subscription_set_queue_capacity(subscription_, kMostMessages);
}

LcmBus::Subscription::~Subscription() {
  lcm_unsubscribe(bus_->lcm_, subscription_);
  const std::lock_guard lock(bus_->mutex_);
  mail_->open = false;
  mail_->messages.clear();
}

void LcmBus::Handle(const lcm_recv_buf_t* received, const char*, void* mail) {
  auto& to = *static_cast<Mail*>(mail);
  const auto* data = static_cast<const char*>(received->data);
  const std::lock_guard lock(to.bus->mutex_);
  if (!to.open) return;
  if (to.messages.size() == kMostMessages) to.messages.pop_front();
  to.messages.emplace_back(data, data + received->data_size);
  to.bus->came_.notify_all();
}

bool LcmBus::Subscription::Take(double timeout_s, std::vector<char>& message) {
  using Clock = std::chrono::steady_clock;
  const auto end = Clock::now() + std::chrono::duration<double>(timeout_s);
  std::unique_lock lock(bus_->mutex_);
  bool drained = false;     // nothing is queued in LCM, as far as this thread can tell
  std::size_t handled = 0;  // here, for others
  while (mail_->messages.empty()) {
    const std::chrono::duration<double> left = end - Clock::now();
    if (drained && left.count() <= 0) return false;
    if (bus_->handling_) {
      drained = true;
      bus_->came_.wait_until(lock, end);
      continue;
    }
    bus_->handling_ = true;
    lock.unlock();
    const double left_ms = std::ceil(1e3 * left.count());
    const int came = lcm_handle_timeout(bus_->lcm_, static_cast<int>(std::clamp(left_ms, 0.0, 1e6)));
    lock.lock();
    bus_->handling_ = false;
    bus_->came_.notify_all();
    if (came < 0 && mail_->messages.empty()) return false;  // a log that has come to its end
    // What is queued is handed out whatever time is left; a sender that never pauses does not hold this up.
    drained = came == 0 || ++handled >= kMostMessages;
  }
  message = std::move(mail_->messages.front());
  mail_->messages.pop_front();
  return true;
}

}  // namespace tenon::internal
