#pragma once

#include <tenon/systems/network/inbox.h>
#include <tenon/systems/network/internal/lcm_type.h>

#include <memory>
#include <string>
#include <vector>

namespace tenon::internal {

class LcmBus;

/// The part of LcmPublisher that does not depend on its type.
class LcmSender {
 public:
  LcmSender(const std::string& channel, const std::string& url, const TypeInfo& type);
  ~LcmSender();
  /// Returns false if LCM refuses the message. `message` is a reusable buffer.
  bool Send(double time, const void* value, std::vector<char>& message) const;

 private:
  const std::string channel_;
  const LcmType type_;
  std::shared_ptr<LcmBus> bus_;
};

/// Makes the inbox of an LcmInput of any type.
std::unique_ptr<Inbox> MakeLcmInbox(const std::string& channel, const std::string& url, Reception reception,
                                    const TypeInfo& type);
void CheckChannel(const std::string& channel);

}  // namespace tenon::internal
