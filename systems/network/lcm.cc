#include <tenon/systems/network/internal/lcm_bus.h>
#include <tenon/systems/network/lcm.h>

#include <fmt/core.h>

namespace tenon::internal {
namespace {

class LcmInbox final : public Inbox {
 public:
  LcmInbox(const std::string& channel, const std::string& url, Reception reception, const TypeInfo& type)
      : Inbox(reception),
        channel_(channel),
        type_(type),
        subscription_(LcmBus::Open(url), channel, reception.lock_step) {}

 private:
  Messages TakeAll() override { return subscription_.TakeAll(); }
  std::optional<std::span<const char>> Receive(double timeout_s) override {
    if (!subscription_.Take(timeout_s, message_)) return {};
    return message_;
  }
  std::string Read(std::span<const char> message, double* timestamp, void* value) override {
    return type_.Decode(message, timestamp, value);
  }
  std::string Description() const override { return fmt::format("LCM channel '{}'", channel_); }

  const std::string channel_;
  const LcmType type_;
  LcmBus::Subscription subscription_;
  std::vector<char> message_;
};

}  // namespace

void CheckChannel(const std::string& channel) {
  Demand(!channel.empty() && channel.size() <= LCM_MAX_CHANNEL_NAME_LENGTH,
         fmt::format("channel = '{}' must have 1 to {} characters", channel, LCM_MAX_CHANNEL_NAME_LENGTH));
}

LcmSender::LcmSender(const std::string& channel, const std::string& url, const TypeInfo& type)
    : channel_(channel), type_(type), bus_(LcmBus::Open(url)) {}

LcmSender::~LcmSender() = default;

bool LcmSender::Send(double time, const void* value, std::vector<char>& message) const {
  type_.Encode(time, value, message);
  return bus_->Publish(channel_, message);
}

std::unique_ptr<Inbox> MakeLcmInbox(const std::string& channel, const std::string& url, Reception reception,
                                    const TypeInfo& type) {
  return std::make_unique<LcmInbox>(channel, url, reception, type);
}

}  // namespace tenon::internal
