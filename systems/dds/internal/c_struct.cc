#include <tenon/systems/dds/internal/c_struct.h>
#include <tenon/systems/framework/types/errors.h>
#include <tenon/systems/ros2/internal/cdr.h>

#include <dds/dds.h>
#include <fmt/core.h>

#include <algorithm>

namespace tenon::internal {
namespace {

using Kind = TypeInfo::Kind;

struct Layout {
  std::size_t size, alignment;
};

/// Calls `visit(field, offset in C, type)` for each member. Returns the layout of the struct.
template <class Visit>
Layout ForEachField(const TypeInfo& type, const Visit& visit);

Layout LayoutOf(const TypeInfo& type) {
  switch (type.kind) {
    case Kind::kNumber:
      return {SizeOf(type.scalar), SizeOf(type.scalar)};
    case Kind::kText:
      return {sizeof(char*), alignof(char*)};
    case Kind::kList:
      return {sizeof(dds_sequence_t), alignof(dds_sequence_t)};
    case Kind::kArray: {
      const Layout item = LayoutOf(type.item());
      return {item.size * type.count, item.alignment};
    }
    case Kind::kStruct:
      return ForEachField(type, [](const Field&, std::size_t, const TypeInfo&) {});
    default:
      throw ParameterError(
          "a message of ROS 2 consists of numbers, texts, std::array, std::vector and structs");
  }
}

template <class Visit>
Layout ForEachField(const TypeInfo& type, const Visit& visit) {
  Layout whole{0, 1};
  for (const Field& field : type.fields) {
    const TypeInfo& of = field.type();
    const Layout part = LayoutOf(of);
    whole.size = AlignUp(whole.size, part.alignment);
    visit(field, whole.size, of);
    whole.size += part.size;
    whole.alignment = std::max(whole.alignment, part.alignment);
  }
  return {AlignUp(whole.size, whole.alignment), whole.alignment};
}

const char* At(const void* value, std::size_t offset) {
  return static_cast<const char*>(value) + offset;
}

/// Writes a value to `memory` + `at`, and lists whose items have another form in C from `end` on, which then
/// is behind them. Without memory, it only finds this end.
void Write(const TypeInfo& type, const void* value, char* memory, std::size_t at, std::size_t& end) {
  const auto put = [&](const void* bytes, std::size_t size) {
    if (memory != nullptr) std::memcpy(memory + at, bytes, size);
  };
  if (type.kind == Kind::kNumber) {
    put(value, SizeOf(type.scalar));
  } else if (type.kind == Kind::kText) {
    const char* text = static_cast<const std::string*>(value)->c_str();
    put(&text, sizeof text);
  } else if (type.kind == Kind::kStruct) {
    ForEachField(type, [&](const Field& field, std::size_t offset, const TypeInfo& of) {
      Write(of, At(value, field.offset), memory, at + offset, end);
    });
  } else {
    const TypeInfo& item = type.item();
    const Items items = ItemsIn(type, value);
    const std::size_t size = LayoutOf(item).size;
    std::size_t to = at;
    if (type.kind == Kind::kList) {
      const bool same = item.kind == Kind::kNumber;
      const auto count = static_cast<std::uint32_t>(items.count);
      char* const buffer = same || memory == nullptr ? items.data : memory + end;
      const dds_sequence_t sequence{count, count, reinterpret_cast<std::uint8_t*>(buffer), false};
      put(&sequence, sizeof sequence);
      if (same) return;
      to = std::exchange(end, end + AlignUp(items.count * size, alignof(std::max_align_t)));
    }
    for (std::size_t i = 0; i < items.count; ++i)
      Write(item, items.data + i * item.size, memory, to + i * size, end);
  }
}

}  // namespace

std::size_t SizeOfC(const TypeInfo& type) {
  return LayoutOf(type).size;
}

void WriteC(const TypeInfo& type, const void* signal, std::vector<char>& memory) {
  const std::size_t size = AlignUp(SizeOfC(type), alignof(std::max_align_t));
  std::size_t end = size;
  Write(type, signal, nullptr, 0, end);
  memory.assign(end, 0);
  Write(type, signal, memory.data(), 0, end = size);
}

std::string ReadC(const TypeInfo& type, const void* message, void* signal) {
  std::string reason;
  if (type.kind == Kind::kNumber) {
    std::memcpy(signal, message, SizeOf(type.scalar));
  } else if (type.kind == Kind::kText) {
    const char* text = nullptr;
    std::memcpy(&text, message, sizeof text);
    *static_cast<std::string*>(signal) = text == nullptr ? "" : text;
  } else if (type.kind == Kind::kStruct) {
    ForEachField(type, [&](const Field& field, std::size_t offset, const TypeInfo& of) {
      if (!reason.empty()) return;
      reason = ReadC(of, At(message, offset), static_cast<char*>(signal) + field.offset);
      if (reason.starts_with(' ')) reason = fmt::format("'{}'{}", field.name, reason);
    });
  } else {
    const TypeInfo& item = type.item();
    const Items items = ItemsIn(type, signal);
    const void* from = message;
    if (type.kind == Kind::kList) {
      dds_sequence_t sequence;
      std::memcpy(&sequence, message, sizeof sequence);
      if (sequence._length != items.count)
        return fmt::format(" has {} elements, but the signal has {}", sequence._length, items.count);
      from = sequence._buffer;
    }
    const std::size_t size = LayoutOf(item).size;
    for (std::size_t i = 0; i < items.count && reason.empty(); ++i)
      reason = ReadC(item, At(from, i * size), items.data + i * item.size);
  }
  return reason;
}

}  // namespace tenon::internal
