#include <tenon/systems/ros2/internal/cdr.h>
#include <tenon/systems/ros2/messages.h>
#include <tenon/systems/ros2/velocity_command.h>

#include <fmt/core.h>

#include <algorithm>
#include <bit>

namespace tenon::internal {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers are copied as they are");

using Kind = TypeInfo::Kind;
constexpr std::size_t kEncapsulation = 4;  // bytes before the message
constexpr char kLittleEndian[kEncapsulation] = {0, 1, 0, 0};

/// Passes the numbers, texts and lengths of lists of a message to a Writer or Reader, in their order.
void Visit(auto& stream, const TypeInfo& type, void* value) {
  if (type.kind == Kind::kNumber) {
    stream.Numbers(value, SizeOf(type.scalar), 1);
  } else if (type.kind == Kind::kText) {
    stream.Text(*static_cast<std::string*>(value));
  } else if (type.kind == Kind::kStruct) {
    for (const Field& field : type.fields)
      Visit(stream, field.type(), static_cast<char*>(value) + field.offset);
  } else {
    const TypeInfo& item = type.item();
    if (type.kind == Kind::kList) stream.Length(type, value);
    const Items items = ItemsIn(type, value);
    if (item.kind == Kind::kNumber) return stream.Numbers(items.data, SizeOf(item.scalar), items.count);
    for (std::size_t i = 0; i < items.count; ++i) Visit(stream, item, items.data + i * item.size);
  }
}

/// Appends to a message. Numbers are aligned to their size from the end of the encapsulation on.
class Writer {
 public:
  explicit Writer(std::vector<char>& out) : out_(out) {}

  void Numbers(const void* data, std::size_t size, std::size_t count) {
    if (count == 0) return;
    while ((out_.size() - kEncapsulation) % size != 0) out_.push_back(0);
    const auto* bytes = static_cast<const char*>(data);
    out_.insert(out_.end(), bytes, bytes + size * count);
  }
  void Text(const std::string& text) {
    Count(text.size() + 1);
    out_.insert(out_.end(), text.c_str(), text.c_str() + text.size() + 1);
  }
  void Length(const TypeInfo& list, void* value) { Count(ItemsIn(list, value).count); }

 private:
  void Count(std::size_t count) {
    const auto number = static_cast<std::uint32_t>(count);
    Numbers(&number, sizeof number, 1);
  }
  std::vector<char>& out_;
};

/// Reads from a message. Once it is not `good`, behind the end, it reads nothing.
class Reader {
 public:
  explicit Reader(std::span<const char> body) : body_(body) {}

  void Numbers(void* data, std::size_t size, std::size_t count) {
    if (count == 0) return;
    const std::size_t begin = (at_ + size - 1) / size * size;
    good_ = good_ && begin <= body_.size() && size * count <= body_.size() - begin;
    if (!good_) return;
    std::memcpy(data, body_.data() + begin, size * count);
    at_ = begin + size * count;
  }
  void Text(std::string& text) {
    const std::size_t size = Count(1);
    text.assign(body_.data() + at_, size == 0 ? 0 : size - 1);
    at_ += size;
  }
  void Length(const TypeInfo& list, void* value) {
    const TypeInfo& item = list.item();
    const std::size_t count =
        Count(item.kind == Kind::kNumber ? SizeOf(item.scalar) : sizeof(std::uint32_t));  // the shortest item
    if (good_) list.resize(value, count, 1);
  }
  bool good() const { return good_; }
  std::size_t rest() const { return body_.size() - at_; }

 private:
  /// Reads a number of items of at least this size, which the rest of the message must hold.
  std::size_t Count(std::size_t item) {
    std::uint32_t count = 0;
    Numbers(&count, sizeof count, 1);
    good_ = good_ && count <= rest() / item;
    return good_ ? count : 0;
  }
  std::span<const char> body_;
  std::size_t at_ = 0;
  bool good_ = true;
};

const char* NameOf(ScalarKind kind) {
  constexpr const char* kNames[] = {"float64", "float32", "bool",   "int8",   "int16", "int32",
                                    "int64",   "uint8",   "uint16", "uint32", "uint64"};
  return kNames[static_cast<std::size_t>(kind)];
}

/// Name of a type in a definition. Structs are added to `contained`.
std::string NameIn(const TypeInfo& type, std::vector<const TypeInfo*>& contained) {
  switch (type.kind) {
    case Kind::kNumber:
      return NameOf(type.scalar);
    case Kind::kText:
      return "string";
    case Kind::kList:
      return NameIn(type.item(), contained) + "[]";
    case Kind::kArray:
      return fmt::format("{}[{}]", NameIn(type.item(), contained), type.count);
    default:
      if (std::ranges::find(contained, &type) == contained.end()) contained.push_back(&type);
      std::string name = ros2::NameOf(type);
      return name.erase(name.find("/msg"), 4);
  }
}

}  // namespace

void WriteCdr(const TypeInfo& type, const void* message, std::vector<char>& out) {
  out.assign(kLittleEndian, kLittleEndian + kEncapsulation);
  Writer writer(out);
  Visit(writer, type, const_cast<void*>(message));
}

std::string ReadCdr(const TypeInfo& type, std::span<const char> cdr, void* message) {
  if (cdr.size() < kEncapsulation || cdr[0] != 0 || cdr[1] != 1)
    return "the message is not in CDR with little endian";
  Reader reader(cdr.subspan(kEncapsulation));
  Visit(reader, type, message);
  if (!reader.good()) return fmt::format("the message has {} bytes and ends too early", cdr.size());
  constexpr std::size_t kPadding = 3;
  if (reader.rest() > kPadding) return fmt::format("the message has {} bytes too many", reader.rest());
  return "";
}

std::string Ros2Definition(const TypeInfo& type) {
  std::vector<const TypeInfo*> contained{&type};
  std::string text;
  for (std::size_t i = 0; i < contained.size(); ++i) {
    const TypeInfo& part = *contained[i];
    std::string name = ros2::NameOf(part);
    if (i > 0) text += std::string(80, '=') + "\nMSG: " + name.erase(name.find("/msg"), 4) + "\n";
    for (const Field& field : part.fields) text += NameIn(field.type(), contained) + " " + field.name + "\n";
  }
  return text;
}

}  // namespace tenon::internal

namespace tenon::ros2 {
namespace {

constexpr std::int64_t kNanoseconds = 1'000'000'000;  // per second

/// The namespace that is the package, and the name of the struct.
std::pair<std::string, std::string> PackageAndName(const internal::TypeInfo& type) {
  std::string full = internal::Demangled(type.id->name());
  const std::size_t name = full.rfind("::");
  if (name == full.npos) return {"", full};
  const std::size_t before = full.rfind("::", name - 1), package = before == full.npos ? 0 : before + 2;
  return {full.substr(package, name - package), full.substr(name + 2)};
}

}  // namespace

builtin_interfaces::Time StampOf(double time) {
  constexpr double kLast = 2147483647;
  const double within = std::clamp(time, 0.0, kLast);
  const std::int64_t nanoseconds = std::llround(within * static_cast<double>(kNanoseconds));
  return {.sec = static_cast<std::int32_t>(nanoseconds / kNanoseconds),
          .nanosec = static_cast<std::uint32_t>(nanoseconds % kNanoseconds)};
}

double TimeOf(const builtin_interfaces::Time& stamp) {
  return stamp.sec + stamp.nanosec / static_cast<double>(kNanoseconds);
}

std::string NameOf(const internal::TypeInfo& type) {
  const auto [package, name] = PackageAndName(type);
  return package + "/msg/" + name;
}

std::string DdsNameOf(const internal::TypeInfo& type) {
  const auto [package, name] = PackageAndName(type);
  return package + "::msg::dds_::" + name + "_";
}

}  // namespace tenon::ros2

TENON_DEFINE_SIGNAL(tenon::ros2::std_msgs::String);
TENON_DEFINE_SIGNAL(tenon::ros2::geometry_msgs::Twist);
TENON_DEFINE_SIGNAL(tenon::ros2::geometry_msgs::WrenchStamped);
TENON_DEFINE_SIGNAL(tenon::ros2::sensor_msgs::JointState);
TENON_DEFINE_SIGNAL(tenon::ros2::sensor_msgs::Imu);
TENON_DEFINE_SIGNAL(tenon::ros2::sensor_msgs::Joy);
TENON_DEFINE_SIGNAL(tenon::ros2::nav_msgs::Odometry);
TENON_DEFINE_SIGNAL(tenon::ros2::tf2_msgs::TFMessage);
TENON_DEFINE_SIGNAL(tenon::ros2::rosgraph_msgs::Clock);
TENON_DEFINE_SIGNAL(tenon::VelocityCommand);
