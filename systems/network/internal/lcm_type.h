#pragma once

#include <tenon/systems/framework/types/internal/type_info.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace tenon::internal {

/// The LCM type for the messages of a signal:
///
///     struct SpringState {
///       double force;  // N
///       double p_W[3];  // m
///     }
///     struct SpringStateSample {
///       double timestamp;  // s
///       SpringState value;
///     }
///
/// Numbers have LCM's types: bool is a boolean, uint8_t a byte, uint16_t and uint32_t the next wider signed
/// type, uint64_t an int64_t with the same bits, and an enumeration its integer. A matrix is an array by
/// rows. Members of variable size are preceded by a member `name_size`, or `name_rows` and `name_cols`.
/// Members that are not numbers are omitted.
class LcmType {
 public:
  /// Throws ParameterError for a type without numbers and for types that LCM does not support: lists of
  /// lists, a structure that contains itself, two structures of one name.
  explicit LcmType(const TypeInfo& value);

  /// Returns the description for lcm-gen.
  std::string Text(const std::string& package) const;
  /// The hash with which messages of the type begin, as computed by lcm-gen.
  std::uint64_t fingerprint() const { return fingerprint_; }

  void Encode(double timestamp, const void* value, std::vector<char>& message) const;
  /// Reads a message. Returns an empty text, or the reason of a refusal, which leaves `value` unchanged.
  /// Sizes must equal those of `value`.
  std::string Decode(std::span<const char> message, double* timestamp, void* value) const;

 private:
  struct Extent {
    std::string size;  ///< a number, or the name of a member
    bool varies;
  };
  struct Member {
    std::string name, unit;
    std::size_t offset;  ///< offset in the structure [bytes]
    const TypeInfo* type;
    ScalarKind scalar = ScalarKind::kDouble;  ///< kind of its numbers, unless it consists of structures
    int structure = -1;
    std::vector<Extent> extents = {};
    std::vector<std::string> sizes = {};  ///< size members that precede it
  };
  struct Structure {
    const TypeInfo* type;
    std::string name;
    std::vector<Member> members = {};
  };
  class Encoder;
  class Decoder;

  int Add(const TypeInfo& type);
  bool Describe(Member& member);
  std::uint64_t Fingerprint(const Structure& structure) const;
  template <class Visitor>
  void Visit(Visitor& visitor, const Structure& structure, const void* value) const;
  template <class Visitor>
  void VisitValue(Visitor& visitor, const Member& member, const TypeInfo& type, const void* value) const;

  std::vector<Structure> structures_;  ///< each after the structures that it contains; the message is last
  std::vector<const TypeInfo*> open_;  ///< structures being added, to detect recursion
  std::uint64_t fingerprint_ = 0;
};

}  // namespace tenon::internal
