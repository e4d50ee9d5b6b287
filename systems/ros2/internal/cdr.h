#pragma once

#include <tenon/systems/framework/types/internal/type_info.h>

namespace tenon::internal {

/// The items of a list or an array.
struct Items {
  std::size_t count;
  char* data;
};
inline Items ItemsIn(const TypeInfo& type, const void* value) {
  void* changeable = const_cast<void*>(value);
  if (type.kind == TypeInfo::Kind::kArray) return {type.count, static_cast<char*>(changeable)};
  return {ExtentsOf(type, value).rows, static_cast<char*>(type.data(changeable))};
}

/// Sets `out` to a message of ROS 2 in CDR (XCDR 1, little endian), with the four bytes of its encapsulation.
void WriteCdr(const TypeInfo& type, const void* message, std::vector<char>& out);

/// Reads such a message; lists get its lengths. Returns an empty text or the reason why it cannot be read,
/// and then `message` is incomplete.
std::string ReadCdr(const TypeInfo& type, std::span<const char> cdr, void* message);

/// The definition of a message with all types that it contains, in the syntax of ROS 2's .msg files
/// ("ros2msg").
std::string Ros2Definition(const TypeInfo& type);

}  // namespace tenon::internal
