#include <tenon/systems/framework/types/errors.h>
#include <tenon/systems/network/internal/lcm_bus.h>
#include <tenon/systems/network/internal/lcm_filter.h>

#include <fmt/core.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <chrono>
#include <cmath>
#include <map>
#include <utility>

namespace tenon::internal {
namespace {

/// Queue length of a subscription; beyond it, the oldest messages are dropped.
constexpr std::size_t kMostMessages = 4096;
/// Maximal number of messages handled at once, so that a fast sender does not block a tick.
constexpr int kMostAtOnce = 1 << 20;

/// Escapes a channel, which LCM interprets as a regular expression.
std::string Quoted(const std::string& channel) {
  std::string quoted;
  for (const char c : channel) {
    if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '_') quoted += '\\';
    quoted += c;
  }
  return quoted;
}

[[noreturn]] void ThrowNotOpen(const std::string& url) {
  throw ParameterError(
      fmt::format("url = '{}': LCM cannot open it, see stderr; use a URL such as "
                  "udpm://239.255.76.67:7667?ttl=0, or an empty "
                  "one for LCM's default; these need a multicast route",
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
  nudge_ = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
}

LcmBus::~LcmBus() {
  watcher_.reset();
  close(nudge_);
  lcm_destroy(lcm_);
}

bool LcmBus::Publish(const std::string& channel, std::span<const char> message) {
  return lcm_publish(lcm_, channel.c_str(), message.data(), static_cast<unsigned>(message.size())) == 0;
}

int LcmBus::HandleAll() {
  int came = 1;
  for (int i = 0; i < kMostAtOnce && came > 0; ++i) came = HandleNext();
  Notify();
  return came;
}

void LcmBus::Notify() {
  came_.notify_all();
  if (waiting_) eventfd_write(nudge_, 1);
}

LcmBus::Subscription::Subscription(std::shared_ptr<LcmBus> bus, const std::string& channel, bool on_demand)
    : bus_(std::move(bus)) {
  const std::lock_guard lock(bus_->mutex_);
  mail_ = &bus_->mails_.emplace_back(Mail{bus_.get()});
  const std::vector<int> before = SharedUdpSockets();
  subscription_ = lcm_subscribe(bus_->lcm_, Quoted(channel).c_str(), &Handle, mail_);
  if (subscription_ == nullptr) ThrowNotOpen(bus_->url_);
  // The first subscription opens the socket that receives.
  for (const int socket : SharedUdpSockets())
    if (std::ranges::count(before, socket) == 0) DropMalformedDatagrams(socket);
  // A full queue of LCM drops new messages. 0 means unlimited, because the watcher empties the queue.
  lcm_subscription_set_queue_capacity(subscription_, on_demand ? static_cast<int>(kMostMessages) : 0);
  if (on_demand || bus_->watcher_) return;
  bus_->watcher_.emplace(lcm_get_fileno(bus_->lcm_), [bus = bus_.get()] {
    const std::lock_guard lock(bus->mutex_);
    return bus->HandleAll() >= 0;
  });
}

LcmBus::Subscription::~Subscription() {
  const std::lock_guard lock(bus_->mutex_);
  lcm_unsubscribe(bus_->lcm_, subscription_);
  mail_->open = false;
  mail_->messages.clear();
}

void LcmBus::Handle(const lcm_recv_buf_t* received, const char*, void* mail) {
  auto& to = *static_cast<Mail*>(mail);
  const auto* data = static_cast<const char*>(received->data);
  if (!to.open) return;
  if (to.messages.size() == kMostMessages) to.messages.pop_front();
  to.messages.emplace_back(data, data + received->data_size);
}

bool LcmBus::Subscription::Take(double timeout_s, std::vector<char>& message) {
  using Clock = std::chrono::steady_clock;
  const auto end = Clock::now() + std::chrono::duration<double>(timeout_s);
  std::unique_lock lock(bus_->mutex_);
  for (;;) {
    int came = 1;
    for (int i = 0; i < kMostAtOnce && came > 0 && mail_->messages.empty(); ++i) came = bus_->HandleNext();
    bus_->Notify();  // other threads may have messages
    if (!mail_->messages.empty()) break;
    const std::chrono::duration<double> left = end - Clock::now();
    if (came < 0 || left.count() <= 0) return false;  // the end of a log file
    if (bus_->waiting_ || bus_->watcher_) {
      bus_->came_.wait_until(lock, end);
      continue;
    }
    bus_->waiting_ = true;
    lock.unlock();
    std::array<pollfd, 2> files{pollfd{lcm_get_fileno(bus_->lcm_), POLLIN, 0},
                                pollfd{bus_->nudge_, POLLIN, 0}};
    poll(files.data(), files.size(), static_cast<int>(std::min(1e6, std::ceil(1e3 * left.count()))));
    lock.lock();
    bus_->waiting_ = false;
    eventfd_t nudges = 0;
    eventfd_read(bus_->nudge_, &nudges);
  }
  message = std::move(mail_->messages.front());
  mail_->messages.pop_front();
  return true;
}

std::deque<std::vector<char>> LcmBus::Subscription::TakeAll() {
  const std::lock_guard lock(bus_->mutex_);
  bus_->HandleAll();
  return std::exchange(mail_->messages, {});
}

}  // namespace tenon::internal
