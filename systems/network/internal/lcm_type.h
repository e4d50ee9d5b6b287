#pragma once

#include <tenon/systems/framework/types/internal/type_info.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace tenon::internal {

/// A type of LCM's that carries a signal:
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
/// Numbers are of LCM's types: bool a boolean, uint8_t a byte, wider unsigned ones the next wider signed one,
/// uint64_t an int64_t of the same bits, an enumeration its integer. A matrix is an array by rows; what has
/// its size at run time has it in a member `name_size`, or `name_rows` and `name_cols`, in front. What is no
/// number is left out.
class LcmType {
 public:
  /// Throws ParameterError for a type without numbers, and for what LCM does not have: lists of lists, a
  /// structure that holds itself, two structures of one name.
  explicit LcmType(const TypeInfo& value);

  /// The description that lcm-gen reads.
  std::string Text(const std::string& package) const;
  /// What messages of the type begin with, as lcm-gen computes it.
  std::uint64_t fingerprint() const { return fingerprint_; }

  void Encode(double timestamp, const void* value, std::vector<char>& message) const;
  /// Returns why the message is refused, with `value` as it was; empty if it is not. Sizes must be those that
  /// `value` has.
  std::string Decode(std::span<const char> message, double* timestamp, void* value) const;

 private:
  struct Extent {
    std::string size;  ///< a number, or the name of a member
    bool varies;
  };
  struct Member {
    std::string name, unit;
    std::size_t offset;  ///< in the structure [bytes]
    const TypeInfo* type;
    ScalarKind scalar = ScalarKind::kDouble;  ///< of its numbers, unless it is made of structures
    int structure = -1;
    std::vector<Extent> extents = {};
    std::vector<std::string> sizes = {};  ///< members in front of it
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

  std::vector<Structure> structures_;  ///< the message last, what it holds before
  std::vector<const TypeInfo*> open_;  ///< while they are added
  std::uint64_t fingerprint_ = 0;
};

}  // namespace tenon::internal
