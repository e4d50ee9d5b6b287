#pragma once

#include <tenon/systems/framework/block/source.h>
#include <tenon/systems/network/inbox.h>
#include <tenon/systems/network/internal/json_writer.h>

#include <memory>
#include <string>

namespace tenon::internal {

class UdpSocket;

/// What a UdpPublisher of any type sends through.
class UdpSender {
 public:
  UdpSender(const std::string& name, const std::string& address, int port, const TypeInfo& type);
  ~UdpSender();
  /// False if the message did not leave. `port` knows what the elements are called.
  bool Send(double time, const Source& port, const void* value, JsonWriter& writer) const;

 private:
  const std::string name_;
  std::unique_ptr<UdpSocket> socket_;
};

struct UdpReception {
  std::string name, address;
  int port;
  Spec spec;  ///< of y
  Reception reception;
};
/// Where the messages of a UdpInput of any type arrive; `port` becomes what the system has chosen.
std::unique_ptr<Inbox> MakeUdpInbox(const UdpReception& reception, const TypeInfo& type, const void* model,
                                    int* port);
void CheckSignalName(const std::string& name);

}  // namespace tenon::internal
