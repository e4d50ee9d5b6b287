#pragma once

#include <tenon/systems/network/inbox.h>

namespace tenon {

/// The place where DDS participants meet.
struct DdsLink {
  int domain = 0;  ///< 0 to 230; participants see only those of their domain
  /// Name of the network interface, such as "eth0", or "lo" for this machine. Empty: as CYCLONEDDS_URI says,
  /// else chosen by Cyclone DDS. All blocks of a program that use a domain have the same interface.
  std::string interface = "";
};

/// The mapping between a signal and a message of DDS, a C struct made by idlc; see MakeDdsMessage and
/// MakeRos2Message.
struct DdsMessage {
  const void* descriptor;  ///< dds_topic_descriptor_t
  std::size_t size;        ///< of the struct [bytes]
  void (*write)(const void* signal, void* message) = nullptr;
  std::string (*read)(const void* message, void* signal) = nullptr;
  /// The type of a signal that is a message of ROS 2 and travels without the functions above; else null.
  const internal::TypeInfo* as_is = nullptr;
};

namespace internal {

/// Returns an empty text, or which number of the value is not finite.
std::string NotFinite(const TypeInfo& type, const void* value);

struct DdsEnd {
  std::string topic;
  DdsLink link;
  bool lock_step;
  int depth = 0;                 ///< of a writer, see DdsPublisherParams
  bool transient_local = false;  ///< of a writer
};

/// Returns the mapping of a message of ROS 2. Throws ParameterError if ros2.idl has no such type.
DdsMessage MakeShippedRos2Message(const TypeInfo& type);

/// The part of DdsPublisher that does not depend on its type.
class DdsSender {
 public:
  virtual ~DdsSender() = default;
  /// Returns false if the message was not sent. `memory` is for the message.
  virtual bool Send(double time, const void* value, std::vector<char>& memory) const = 0;
};

std::unique_ptr<DdsSender> MakeDdsSender(const DdsEnd& end, const DdsMessage& message);
/// Makes the inbox of a DdsInput of any type. `timeout_s` is that of lock-step.
std::unique_ptr<Inbox> MakeDdsInbox(const DdsEnd& end, const DdsMessage& message, double timeout_s);

}  // namespace internal
}  // namespace tenon
