#pragma once

#include <tenon/systems/framework/block/source.h>
#include <tenon/systems/network/inbox.h>
#include <tenon/systems/network/internal/json.h>

namespace tenon::internal {

class UdpSocket;

/// The part of UdpPublisher that does not depend on its type.
class UdpSender {
 public:
  UdpSender(const std::string& name, const std::string& address, int port, const TypeInfo& type);
  ~UdpSender();
  /// Returns false if the message was not sent. `port` determines the names of the elements.
  bool Send(double time, const Source& port, const void* value, JsonWriter& writer) const;

 private:
  const std::string name_;
  std::unique_ptr<UdpSocket> socket_;
};

struct UdpReception {
  std::string name, address;
  int port;
  Spec spec;  ///< spec of y
  Reception reception;
};
/// Makes the inbox of a UdpInput of any type. Sets `port` to the actual port.
std::unique_ptr<Inbox> MakeUdpInbox(const UdpReception& reception, const TypeInfo& type, const void* model,
                                    int* port);
void CheckSignalName(const std::string& name);

}  // namespace tenon::internal
