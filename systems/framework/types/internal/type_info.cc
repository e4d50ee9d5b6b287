#include <tenon/systems/framework/types/internal/type_info.h>
#include <tenon/systems/framework/types/signal.h>

#include <cxxabi.h>
#include <fmt/core.h>

#include <algorithm>
#include <regex>

namespace tenon::internal {
namespace {

using Kind = TypeInfo::Kind;

void Append(std::vector<ScalarRun>& runs, std::size_t offset, std::size_t count, ScalarKind kind) {
  if (count == 0) return;
  if (!runs.empty() && runs.back().kind == kind &&
      runs.back().offset + runs.back().count * SizeOf(kind) == offset) {
    runs.back().count += static_cast<std::uint32_t>(count);
  } else {
    runs.push_back({static_cast<std::uint32_t>(offset), static_cast<std::uint32_t>(count), kind});
  }
}

/// Appends the runs of a value that lies at `offset`; false if the type has no fixed runs.
bool AppendRuns(const TypeInfo& type, std::size_t offset, std::vector<ScalarRun>& runs) {
  switch (type.kind) {
    case Kind::kNumber:
      Append(runs, offset, 1, type.scalar);
      return true;
    case Kind::kMatrix:
      if (type.rows < 0 || type.cols < 0) return false;
      Append(runs, offset, static_cast<std::size_t>(type.rows * type.cols), type.scalar);
      return true;
    case Kind::kStruct:
      for (const Field& field : type.fields) {
        if (!AppendRuns(field.type(), offset + field.offset, runs)) return false;
      }
      return true;
    case Kind::kArray:
      for (std::size_t i = 0; i < type.count; ++i) {
        if (!AppendRuns(type.item(), offset + i * type.item().size, runs)) return false;
      }
      return true;
    default:
      return false;
  }
}

void WalkItems(const TypeInfo& item, void* first, std::size_t count, ValueVisitor& visitor) {
  for (std::size_t i = 0; i < count; ++i) {
    visitor.EnterItem(i);
    Walk(item, static_cast<std::byte*>(first) + i * item.size, visitor);
    visitor.Leave();
  }
}

bool CanHave(const TypeInfo& type, std::size_t rows, std::size_t cols) {
  if (type.kind == Kind::kOptional) return rows <= 1 && cols == 1;
  if (type.kind == Kind::kList) return cols == 1;
  const auto agrees = [](int fixed, std::size_t size) {
    return fixed < 0 ? size <= PTRDIFF_MAX : static_cast<std::size_t>(fixed) == size;
  };
  return agrees(type.rows, rows) && agrees(type.cols, cols) && (rows == 0 || cols <= type.capacity / rows);
}

/// Changes the size if the visitor requests it. Throws RunError if the type cannot have that size.
void Resize(const TypeInfo& type, void* value, ValueVisitor& visitor, std::size_t* rows, std::size_t* cols) {
  type.shape(value, rows, cols);
  std::size_t wanted_rows = *rows, wanted_cols = *cols;
  visitor.Resize(&wanted_rows, &wanted_cols);
  if (wanted_rows == *rows && wanted_cols == *cols) return;
  if (!CanHave(type, wanted_rows, wanted_cols))
    throw RunError(fmt::format("a {} cannot be {} by {}", TypeName(type), wanted_rows, wanted_cols));
  type.resize(value, wanted_rows, wanted_cols);
  *rows = wanted_rows, *cols = wanted_cols;
}

std::string Extent(int number) {
  return number < 0 ? "X" : std::to_string(number);
}

std::string MatrixName(int rows, int cols, const std::string& scalar) {
  const std::string of = scalar == "double" ? "" : ", " + scalar;
  if (cols == 1) return fmt::format("Vec<{}{}>", Extent(rows), of);
  return fmt::format("Mat<{}, {}{}>", Extent(rows), Extent(cols), of);
}

/// Removes namespaces, and writes matrices among template arguments like MatrixName.
std::string Shortened(std::string name) {
  static const std::regex kNamespaces(R"(tenon::|\(anonymous namespace\)::)");
  static const std::regex kGap("> (?=>)");
  static const std::regex kMatrix(R"(Eigen::Matrix<(\w+), (-?\d+), (-?\d+), -?\d+, -?\d+, -?\d+>)");
  name = std::regex_replace(std::regex_replace(name, kNamespaces, ""), kGap, ">");
  for (std::smatch match; std::regex_search(name, match, kMatrix);) {
    const std::string matrix = MatrixName(std::stoi(match[2]), std::stoi(match[3]), match[1]);
    name = match.prefix().str() + matrix + match.suffix().str();
  }
  return name;
}

}  // namespace

std::string Demangled(const char* name) {
  int status = 0;
  const std::unique_ptr<char, void (*)(void*)> text(abi::__cxa_demangle(name, nullptr, nullptr, &status),
                                                    FreeMalloced);
  return status == 0 ? text.get() : name;
}

std::string TypeName(const TypeInfo& type) {
  switch (type.kind) {
    case Kind::kArray:
      return fmt::format("std::array<{}, {}>", TypeName(type.item()), type.count);
    case Kind::kList:
      return fmt::format("std::vector<{}>", TypeName(type.item()));
    case Kind::kOptional:
      return fmt::format("std::optional<{}>", TypeName(type.item()));
    case Kind::kMap:
      return fmt::format("std::map<std::string, {}>", TypeName(type.item()));
    case Kind::kText:
      return "std::string";
    default:
      return Shortened(Demangled(type.id->name()));
  }
}

AnyValue::Memory AnyValue::Allocate(const TypeInfo& type) {
  const auto alignment = static_cast<std::align_val_t>(type.alignment);
  return {::operator new(type.size, alignment), {alignment}};
}

AnyValue::AnyValue(const TypeInfo& type, const void* model) : type_(type), memory_(Allocate(type)) {
  type.copy_construct(get(), model);
}

AnyValue::AnyValue(const TypeInfo& type, std::byte content) : type_(type), memory_(Allocate(type)) {
  std::memset(get(), static_cast<int>(content), type.size);
  type.construct(get());
}

std::size_t SizeOf(ScalarKind kind) {
  std::size_t size = 0;
  WithKind(kind, nullptr, [&]<class T>(T*) { size = sizeof(T); });
  return size;
}

long long LoadInteger(ScalarKind kind, const void* value) {
  long long integer = 0;
  WithKind(kind, const_cast<void*>(value),
           [&](const auto* number) { integer = static_cast<long long>(*number); });
  return integer;
}

void StoreInteger(ScalarKind kind, void* value, long long integer) {
  WithKind(kind, value, [&]<class T>(T* number) { *number = static_cast<T>(integer); });
}

namespace {

/// Number of elements of a vector or items of an array; 0 if there is none or it is known only at run time.
std::size_t NumNamed(const TypeInfo& type) {
  if (type.kind == Kind::kArray) return type.count;
  if (type.kind != Kind::kMatrix || type.shape != nullptr) return 0;
  return static_cast<std::size_t>(type.rows) * static_cast<std::size_t>(type.cols);
}

void CheckElementNames(const TypeInfo& type) {
  for (const Field& field : type.fields) {
    const std::size_t names = ListLength(field.elements), named = NumNamed(field.type());
    if (names == 0 || named == 0 || names == named) continue;
    throw BuildError(fmt::format("member '{}' of {} has {} elements but {} names ({}): give one for each",
                                 field.name, TypeName(type), named, names, field.elements));
  }
}

/// Members that a constructor leaves uninitialised differ if the memory differed before.
void CheckMembersAreWritten(const TypeInfo& type) {
  if (type.kind != Kind::kStruct || type.construct == nullptr) return;
  const AnyValue one(type, std::byte{0x00}), other(type, std::byte{0xa5});
  const auto *first = static_cast<const std::byte*>(one.get()),
             *second = static_cast<const std::byte*>(other.get());
  for (const Field& field : type.fields) {
    for (const ScalarRun& run : field.type().runs) {
      const std::size_t offset = field.offset + run.offset;
      if (std::memcmp(first + offset, second + offset, run.count * SizeOf(run.kind)) == 0) continue;
      throw BuildError(
          fmt::format("member '{}' of {} is uninitialised in `{} value;`. Give it a value where "
                      "it is declared: `= 0`, `= Vec<3>::Zero()`; braces do not make an Eigen matrix zero",
                      field.name, TypeName(type), TypeName(type)));
    }
  }
}

/// `how_many` as in "2 of its 5 members are missing"; `where` describes the gaps that were found.
[[noreturn]] void ThrowForgotten(const TypeInfo& type, const std::string& how_many,
                                 const std::string& where) {
  throw BuildError(fmt::format(
      "Fields() of {} does not list all members: {}{}. Snapshots, logs and files would lack them: list "
      "each, as Undescribed(&{}::member) to omit it from these",
      TypeName(type), how_many, where, TypeName(type)));
}

/// Bytes without a listed member that cannot be padding.
struct Gap {
  std::size_t size = 0;
  const Field* before = nullptr;  ///< null if the gap is before all members
};

std::vector<Gap> FindGaps(const TypeInfo& type, const FieldList& fields, std::size_t begin) {
  std::vector<const Field*> sorted;
  for (const Field& field : fields) sorted.push_back(&field);
  std::ranges::stable_sort(sorted, {}, &Field::whole);
  std::vector<Gap> gaps;
  std::size_t end = begin;
  const Field* last = nullptr;
  const auto check_gap = [&](std::size_t next) {
    if (next <= end) return;
    for (std::size_t alignment = 1; alignment <= type.alignment; alignment *= 2) {
      if (AlignUp(end, alignment) == next) return;
    }
    gaps.push_back({next - end, last});
  };
  for (const Field* field : sorted) {
    check_gap(field->whole);
    end = std::max(end, field->whole + field->whole_size);
    last = field;
  }
  check_gap(type.size);
  return gaps;
}

std::string Described(const std::vector<Gap>& gaps) {
  std::string text;
  for (const Gap& gap : gaps) {
    text += fmt::format(", {} bytes {}", gap.size,
                        gap.before == nullptr       ? "before the first member"
                        : *gap.before->name == '\0' ? "after a member without description"
                                                    : fmt::format("after '{}'", gap.before->name));
  }
  return text;
}

}  // namespace

void SetFields(TypeInfo& info, FieldList fields, int members, std::size_t begin) {
  std::map<std::size_t, std::size_t> listed;  // a member may be listed more than once
  for (const Field& field : fields) listed[field.whole] = field.initializers;
  int missing = members;
  for (const auto& [offset, initializers] : listed) missing -= static_cast<int>(initializers);
  const std::vector<Gap> gaps = FindGaps(info, fields, begin);
  if (members >= 0 && missing > 0) {
    ThrowForgotten(
        info, fmt::format("{} of its {} members {} missing", missing, members, missing == 1 ? "is" : "are"),
        Described(gaps));
  }
  if (members < 0 && !gaps.empty()) ThrowForgotten(info, "some are missing", Described(gaps));
  info.omits =
      std::ranges::any_of(fields, [](const Field& field) { return !field.described && !field.constant; });
  std::erase_if(fields, [](const Field& field) { return !field.described; });
  info.fields = std::move(fields);
}

TypeInfo WithRuns(TypeInfo info) {
  info.fixed = AppendRuns(info, 0, info.runs);
  if (!info.fixed) info.runs.clear();
  for (const ScalarRun& run : info.runs) info.num_scalars += run.count;
  CheckElementNames(info);
  CheckMembersAreWritten(info);
  return info;
}

void Walk(const TypeInfo& type, void* value, ValueVisitor& visitor) {
  std::size_t rows = 0, cols = 1;
  switch (type.kind) {
    case Kind::kNumber:
      return visitor.Number(value, type);
    case Kind::kMatrix:
      rows = static_cast<std::size_t>(type.rows), cols = static_cast<std::size_t>(type.cols);
      if (type.shape != nullptr) Resize(type, value, visitor, &rows, &cols);
      return visitor.Numbers(type.data(value), type.scalar, rows, cols);
    case Kind::kStruct:
      visitor.Struct(type);
      for (const Field& field : type.fields) {
        visitor.EnterMember(field);
        Walk(field.type(), static_cast<std::byte*>(value) + field.offset, visitor);
        visitor.Leave();
      }
      return;
    case Kind::kArray:
      return WalkItems(type.item(), value, type.count, visitor);
    case Kind::kList:
    case Kind::kOptional:
      Resize(type, value, visitor, &rows, &cols);
      if (rows > 0) WalkItems(type.item(), type.data(value), rows, visitor);
      return;
    case Kind::kText:
      return visitor.Text(*static_cast<std::string*>(value));
    case Kind::kMap:
    case Kind::kOpaque:
      return visitor.Opaque(type, value);
  }
}

}  // namespace tenon::internal

TENON_DEFINE_SIGNAL(bool);
TENON_DEFINE_SIGNAL(int);
TENON_DEFINE_SIGNAL(double);
TENON_DEFINE_SIGNAL(std::uint64_t);
TENON_DEFINE_SIGNAL(std::string);
TENON_DEFINE_SIGNAL(std::vector<double>);
TENON_DEFINE_SIGNAL(std::vector<std::string>);
TENON_DEFINE_SIGNAL(Eigen::Vector3d);
TENON_DEFINE_SIGNAL(Eigen::Matrix3d);
TENON_DEFINE_SIGNAL(Eigen::VectorXd);
TENON_DEFINE_SIGNAL(Eigen::Matrix<double, 2, 1, Eigen::DontAlign>);
TENON_DEFINE_SIGNAL(Eigen::Matrix<double, 4, 1, Eigen::DontAlign>);
TENON_DEFINE_SIGNAL(Eigen::Matrix<double, 6, 1, Eigen::DontAlign>);
TENON_DEFINE_SIGNAL(Eigen::Matrix<double, 12, 1, Eigen::DontAlign>);
