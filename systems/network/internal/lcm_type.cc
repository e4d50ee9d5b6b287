#include <tenon/systems/framework/types/errors.h>
#include <tenon/systems/framework/types/signal.h>
#include <tenon/systems/network/internal/lcm_type.h>

#include <fmt/core.h>

#include <algorithm>
#include <bit>
#include <cctype>
#include <cstring>
#include <limits>
#include <string_view>
#include <type_traits>

namespace tenon::internal {
namespace {

using Kind = TypeInfo::Kind;

struct WireType {
  const char* name;
  std::size_t size;  ///< [bytes]
};
WireType WireTypeOf(ScalarKind kind) {
  switch (kind) {
    case ScalarKind::kDouble:
      return {"double", 8};
    case ScalarKind::kFloat:
      return {"float", 4};
    case ScalarKind::kBool:
      return {"boolean", 1};
    case ScalarKind::kInt8:
      return {"int8_t", 1};
    case ScalarKind::kUint8:
      return {"byte", 1};
    case ScalarKind::kInt16:
      return {"int16_t", 2};
    case ScalarKind::kInt32:
    case ScalarKind::kUint16:
      return {"int32_t", 4};
    case ScalarKind::kInt64:
    case ScalarKind::kUint32:
    case ScalarKind::kUint64:
      break;
  }
  return {"int64_t", 8};
}

/// Converts a type name to a name for lcm-gen: "ns::Pair<double, 2>" to "Pair_double_2".
std::string Identifier(const std::string& text) {
  std::string name;
  std::size_t word = 0;  // begin of the current word
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto c = static_cast<unsigned char>(text[i]);
    if (std::isalnum(c) != 0 || c == '_') {
      if (name.empty() && std::isdigit(c) != 0) name += '_';
      name += text[i];
    } else if (text.compare(i, 2, "::") == 0) {
      name.resize(word);
      ++i;
    } else {
      if (!name.empty() && name.back() != '_') name += '_';
      word = name.size();
    }
  }
  while (name.size() > 1 && name.back() == '_') name.pop_back();
  return name;
}

// The hash of a description as in lcm-gen.
std::uint64_t HashByte(std::uint64_t hash, char c) {
  const auto sign_extended = static_cast<std::uint64_t>(static_cast<std::int64_t>(hash) >> 55);
  return ((hash << 8) ^ sign_extended) + static_cast<std::uint64_t>(static_cast<signed char>(c));
}
std::uint64_t HashText(std::uint64_t hash, std::string_view text) {
  hash = HashByte(hash, static_cast<char>(text.size()));
  for (const char c : text) hash = HashByte(hash, c);
  return hash;
}

}  // namespace

LcmType::LcmType(const TypeInfo& value) {
  Member member{"value", "", 0, &value};
  if (!Describe(member)) {
    throw ParameterError(
        fmt::format("{} holds no numbers to send: give it a static Fields()", TypeName(value)));
  }
  structures_.push_back({nullptr, Identifier(TypeName(value)) + "Sample"});
  structures_.back().members.push_back(std::move(member));
  fingerprint_ = Fingerprint(structures_.back());
}

/// Returns the index of the structure, or -1 if it has no numbers.
int LcmType::Add(const TypeInfo& type) {
  const std::string name = Identifier(TypeName(type));
  for (std::size_t i = 0; i < structures_.size(); ++i) {
    if (*structures_[i].type->id == *type.id) return static_cast<int>(i);
    if (structures_[i].name == name) {
      throw ParameterError(fmt::format(
          "two types have the name {} without namespaces, which LCM does not have: rename one", name));
    }
  }
  if (std::find(open_.begin(), open_.end(), &type) != open_.end()) {
    throw ParameterError(fmt::format("{} contains items of its own type, which LCM does not support", name));
  }
  open_.push_back(&type);
  Structure structure{&type, name};
  for (const Field& field : type.fields) {
    Member member{Identifier(field.name), field.units, field.offset, &field.type()};
    if (Describe(member)) structure.members.push_back(std::move(member));
  }
  open_.pop_back();
  if (structure.members.empty()) return -1;
  structures_.push_back(std::move(structure));
  return static_cast<int>(structures_.size()) - 1;
}

/// Describes a member by its type; returns false if it has no numbers.
bool LcmType::Describe(Member& member) {
  const auto demand_outermost = [&] {
    if (member.extents.empty()) return;
    throw ParameterError(
        fmt::format("'{}' is an array of what has its size at run time, which LCM does not have: put that "
                    "into a structure",
                    member.name));
  };
  const auto varying = [&](const char* suffix) {
    member.sizes.push_back(member.name + suffix);
    member.extents.push_back({member.sizes.back(), true});
  };
  const auto constant = [&](auto count) { member.extents.push_back({std::to_string(count), false}); };
  for (const TypeInfo* type = member.type;; type = &type->item()) {
    switch (type->kind) {
      case Kind::kNumber:
        member.scalar = type->scalar;
        return true;
      case Kind::kMatrix:
        member.scalar = type->scalar;
        if (type->shape != nullptr) demand_outermost();
        if (type->cols == 1) {
          type->rows < 0 ? varying("_size") : constant(type->rows);
        } else {
          type->rows < 0 ? varying("_rows") : constant(type->rows);
          type->cols < 0 ? varying("_cols") : constant(type->cols);
        }
        return true;
      case Kind::kStruct:
        member.structure = Add(*type);
        return member.structure >= 0;
      case Kind::kArray:
        constant(type->count);
        break;
      case Kind::kList:
      case Kind::kOptional:
        demand_outermost();
        varying("_size");
        break;
      default:
        return false;
    }
  }
}

std::string LcmType::Text(const std::string& package) const {
  std::string text = fmt::format("package {};\n", package);
  for (const Structure& structure : structures_) {
    text += fmt::format("\nstruct {} {{\n", structure.name);
    if (structure.type == nullptr) text += "  double timestamp;  // s\n";
    for (const Member& member : structure.members) {
      for (const std::string& size : member.sizes) text += fmt::format("  int32_t {};\n", size);
      const auto of = static_cast<std::size_t>(member.structure);
      text +=
          fmt::format("  {} {}", member.structure < 0 ? WireTypeOf(member.scalar).name : structures_[of].name,
                      member.name);
      for (const Extent& extent : member.extents) text += fmt::format("[{}]", extent.size);
      text += member.unit.empty() ? ";\n" : fmt::format(";  // {}\n", member.unit);
    }
    text += "}\n";
  }
  return text;
}

std::uint64_t LcmType::Fingerprint(const Structure& structure) const {
  std::uint64_t hash = 0x12345678;
  const auto add = [&](const std::string& name, const char* type, const std::vector<Extent>& extents) {
    hash = HashText(hash, name);
    if (type != nullptr) hash = HashText(hash, type);
    hash = HashByte(hash, static_cast<char>(extents.size()));
    for (const Extent& extent : extents) {
      hash = HashText(HashByte(hash, extent.varies ? 1 : 0), extent.size);
    }
  };
  if (structure.type == nullptr) add("timestamp", "double", {});
  for (const Member& member : structure.members) {
    for (const std::string& size : member.sizes) add(size, "int32_t", {});
    add(member.name, member.structure < 0 ? WireTypeOf(member.scalar).name : nullptr, member.extents);
  }
  for (const Member& member : structure.members) {
    if (member.structure >= 0) hash += Fingerprint(structures_[static_cast<std::size_t>(member.structure)]);
  }
  return std::rotl(hash, 1);
}

// Messages.

template <class Visitor>
void LcmType::Visit(Visitor& visitor, const Structure& structure, const void* value) const {
  for (const Member& member : structure.members) {
    const auto* place = static_cast<const std::byte*>(value) + member.offset;
    if (!member.sizes.empty()) {
      const TypeInfo* type = member.type;
      // The sizes belong to the outermost list or matrix, which is a member of the structure.
      std::size_t extents[2];
      type->shape(place, &extents[0], &extents[1]);
      const bool columns_vary_alone = type->kind == Kind::kMatrix && type->rows >= 0;
      for (std::size_t i = 0; i < member.sizes.size(); ++i) {
        visitor.Size(static_cast<std::int32_t>(extents[columns_vary_alone ? 1 : i]), member.sizes[i]);
      }
    }
    VisitValue(visitor, member, *member.type, place);
  }
}

template <class Visitor>
void LcmType::VisitValue(Visitor& visitor, const Member& member, const TypeInfo& type,
                         const void* value) const {
  std::size_t rows = 0, cols = 1;
  const auto* bytes = static_cast<const std::byte*>(value);
  switch (type.kind) {
    case Kind::kNumber:
      return visitor.Number(type, value, member.name);
    case Kind::kMatrix: {
      rows = static_cast<std::size_t>(type.rows), cols = static_cast<std::size_t>(type.cols);
      if (type.shape != nullptr) type.shape(value, &rows, &cols);
      const auto* first = static_cast<const std::byte*>(type.data(const_cast<void*>(value)));
      const std::size_t size = SizeOf(type.scalar);
      for (std::size_t r = 0; r < rows; ++r) {
        for (std::size_t c = 0; c < cols; ++c) {
          visitor.Number(type, first + (c * rows + r) * size, member.name);
        }
      }
      return;
    }
    case Kind::kStruct:
      return Visit(visitor, structures_[static_cast<std::size_t>(member.structure)], value);
    case Kind::kArray:
      rows = type.count;
      break;
    default:
      type.shape(value, &rows, &cols);
      if (rows > 0) bytes = static_cast<const std::byte*>(type.data(const_cast<void*>(value)));
  }
  for (std::size_t i = 0; i < rows; ++i)
    VisitValue(visitor, member, type.item(), bytes + i * type.item().size);
}

class LcmType::Encoder {
 public:
  explicit Encoder(std::vector<char>& message) : message_(message) {}
  void Put(std::uint64_t bits, std::size_t size) {
    for (std::size_t i = size; i-- > 0;) message_.push_back(static_cast<char>(bits >> (8 * i)));
  }
  void Size(std::int32_t size, const std::string&) { Put(static_cast<std::uint32_t>(size), 4); }
  void Number(const TypeInfo& type, const void* value, const std::string&) {
    WithKind(type.scalar, const_cast<void*>(value), [&]<class T>(const T* number) {
      if constexpr (std::is_same_v<T, double>) {
        Put(std::bit_cast<std::uint64_t>(*number), 8);
      } else if constexpr (std::is_same_v<T, float>) {
        Put(std::bit_cast<std::uint32_t>(*number), 4);
      } else {
        Put(static_cast<std::uint64_t>(*number), WireTypeOf(type.scalar).size);
      }
    });
  }

 private:
  std::vector<char>& message_;
};

void LcmType::Encode(double timestamp, const void* value, std::vector<char>& message) const {
  message.clear();
  Encoder encoder(message);
  encoder.Put(fingerprint_, 8);
  encoder.Put(std::bit_cast<std::uint64_t>(timestamp), 8);
  Visit(encoder, structures_.back(), value);
}

/// Decodes a message in two passes: the first one checks it, the second one stores the values.
class LcmType::Decoder {
 public:
  explicit Decoder(std::span<const char> message) : message_(message) {}
  bool exhausted() const { return cursor_ == message_.size(); }
  void StoreFrom(std::size_t cursor) {
    cursor_ = cursor;
    stores_ = true;
  }
  std::uint64_t Get(std::size_t size) {
    if (message_.size() - cursor_ < size) {
      Refuse(fmt::format("the message is truncated: {} bytes are too few", message_.size()));
      return 0;
    }
    std::uint64_t bits = 0;
    for (std::size_t i = 0; i < size; ++i) {
      bits = bits << 8 | static_cast<unsigned char>(message_[cursor_++]);
    }
    return bits;
  }
  void Size(std::int32_t size, const std::string& name) {
    const auto given = static_cast<std::int32_t>(Get(4));
    if (given != size) Refuse(fmt::format("'{}' is {}, but the signal has {}", name, given, size));
  }
  void Number(const TypeInfo& type, const void* value, const std::string& name) {
    const std::size_t size = WireTypeOf(type.scalar).size;
    const std::uint64_t bits = Get(size);
    WithKind(type.scalar, const_cast<void*>(value), [&]<class T>(T* number) {
      T result;
      if constexpr (std::is_same_v<T, double>) {
        result = std::bit_cast<double>(bits);
      } else if constexpr (std::is_same_v<T, float>) {
        result = std::bit_cast<float>(static_cast<std::uint32_t>(bits));
      } else {
        result = static_cast<T>(bits);
        const std::uint64_t again = static_cast<std::uint64_t>(result) << (64 - 8 * size) >> (64 - 8 * size);
        if (again != bits) Refuse(fmt::format("'{}' holds a number that its type cannot represent", name));
        if (!IsNamed(type, &result))
          Refuse(fmt::format("'{}' = {} must be one of {}", name, result, NamedValues(type)));
      }
      if (stores_) *number = result;
    });
  }
  void Refuse(std::string why) {
    if (reason.empty()) reason = std::move(why);
  }
  std::string reason;

 private:
  std::span<const char> message_;
  std::size_t cursor_ = 0;
  bool stores_ = false;
};

std::string LcmType::Decode(std::span<const char> message, double* timestamp, void* value) const {
  Decoder decoder(message);
  if (const std::uint64_t given = decoder.Get(8); decoder.reason.empty() && given != fingerprint_) {
    return fmt::format("the message has another type than {}: its fingerprint is {:#018x}, not {:#018x}",
                       structures_.back().name, given, fingerprint_);
  }
  const auto time = std::bit_cast<double>(decoder.Get(8));
  Visit(decoder, structures_.back(), value);
  if (!decoder.exhausted()) decoder.Refuse("the message is longer than its type");
  if (!decoder.reason.empty()) return decoder.reason;
  decoder.StoreFrom(16);
  Visit(decoder, structures_.back(), value);
  *timestamp = time;
  return "";
}

}  // namespace tenon::internal
