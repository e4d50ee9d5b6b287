#pragma once

#include <tenon/systems/framework/types/fields.h>
#include <tenon/systems/framework/types/internal/border.h>
#include <tenon/systems/framework/types/internal/member_count.h>

#include <cstdint>
#include <map>
#include <new>
#include <optional>

namespace tenon::internal {

template <class T>
concept Scalar = std::is_arithmetic_v<T> || std::is_enum_v<T>;

template <class T>
concept EigenMatrix = std::is_base_of_v<Eigen::MatrixBase<T>, T>;

/// A matrix whose numbers are stored inside the object.
template <class T>
concept InlineMatrix = EigenMatrix<T> && T::MaxSizeAtCompileTime != Eigen::Dynamic;

/// True if copying the bytes copies the value.
template <class T>
inline constexpr bool kBitwise = std::is_trivially_copyable_v<T> || InlineMatrix<T> ||
                                 (HasFields<T> && std::is_trivially_destructible_v<T>);

enum class ScalarKind : std::uint8_t {
  kDouble,
  kFloat,
  kBool,
  kInt8,
  kInt16,
  kInt32,
  kInt64,
  kUint8,
  kUint16,
  kUint32,
  kUint64
};

template <Scalar T>
constexpr ScalarKind KindOf() {
  if constexpr (std::is_enum_v<T>) {
    return KindOf<std::underlying_type_t<T>>();
  } else if constexpr (std::is_floating_point_v<T>) {
    static_assert(sizeof(T) <= sizeof(double), "signals consist of double or float, not of long double");
    return sizeof(T) == sizeof(double) ? ScalarKind::kDouble : ScalarKind::kFloat;
  } else if constexpr (std::is_same_v<T, bool>) {
    return ScalarKind::kBool;
  } else {
    constexpr int kLog2 = sizeof(T) == 1 ? 0 : sizeof(T) == 2 ? 1 : sizeof(T) == 4 ? 2 : 3;
    constexpr auto kFirst = std::is_signed_v<T> ? ScalarKind::kInt8 : ScalarKind::kUint8;
    return static_cast<ScalarKind>(static_cast<int>(kFirst) + kLog2);
  }
}

/// Calls `visit(T*)` with a pointer of the kind's type.
template <class Visit>
void WithKind(ScalarKind kind, void* data, const Visit& visit) {
  switch (kind) {
    case ScalarKind::kDouble:
      return visit(static_cast<double*>(data));
    case ScalarKind::kFloat:
      return visit(static_cast<float*>(data));
    case ScalarKind::kBool:
      return visit(static_cast<bool*>(data));
    case ScalarKind::kInt8:
      return visit(static_cast<std::int8_t*>(data));
    case ScalarKind::kInt16:
      return visit(static_cast<std::int16_t*>(data));
    case ScalarKind::kInt32:
      return visit(static_cast<std::int32_t*>(data));
    case ScalarKind::kInt64:
      return visit(static_cast<std::int64_t*>(data));
    case ScalarKind::kUint8:
      return visit(static_cast<std::uint8_t*>(data));
    case ScalarKind::kUint16:
      return visit(static_cast<std::uint16_t*>(data));
    case ScalarKind::kUint32:
      return visit(static_cast<std::uint32_t*>(data));
    case ScalarKind::kUint64:
      return visit(static_cast<std::uint64_t*>(data));
  }
}

std::size_t SizeOf(ScalarKind kind);  ///< [bytes]
long long LoadInteger(ScalarKind kind, const void* value);
void StoreInteger(ScalarKind kind, void* value, long long integer);

/// Consecutive numbers of one kind.
struct ScalarRun {
  std::uint32_t offset;  ///< distance from the beginning of the value [bytes]
  std::uint32_t count;
  ScalarKind kind;
};

struct NamedValue {
  long long value;
  const char* name;
};

/// Description of a value's type: how to copy it, and its contents. Contexts, logs, snapshots and YAML files
/// work with this description, so that none of them is a template.
struct TypeInfo {
  enum class Kind {
    kNumber,    ///< `scalar`; an enumeration has `names`
    kMatrix,    ///< matrix of `scalar`, column-major; `rows` and `cols` are -1 if known only at run time
    kStruct,    ///< `fields`
    kArray,     ///< `count` items
    kList,      ///< items; their number can change
    kOptional,  ///< one item, or none
    kMap,       ///< items by name
    kText,      ///< std::string
    kOpaque,    ///< does not describe itself
  };
  Kind kind = Kind::kOpaque;
  const std::type_info* id = nullptr;
  std::size_t size = 0;
  std::size_t alignment = 0;
  bool bitwise = false;
  bool trivial = false;                   ///< std::is_trivially_copyable
  void (*construct)(void* at) = nullptr;  ///< like `T value;`; null if T is not default constructible
  void (*copy_construct)(void* at, const void* model) = nullptr;
  void (*destroy)(void* value) = nullptr;
  void (*assign)(void* to, const void* from) = nullptr;

  ScalarKind scalar = ScalarKind::kDouble;
  std::vector<NamedValue> names = {};

  int rows = 0, cols = 0;
  std::size_t capacity = SIZE_MAX;       ///< maximum number of elements of a matrix
  void* (*data)(void* value) = nullptr;  ///< first element of a matrix or list, item of an optional
  void (*shape)(const void* value, std::size_t* rows, std::size_t* cols) = nullptr;  ///< a list has cols = 1
  void (*resize)(void* value, std::size_t rows, std::size_t cols) = nullptr;

  FieldList fields = {};
  bool omits = false;  ///< a struct with members that are not described and not pointers to constant data
  std::vector<std::byte> (*save)(const void* value) = nullptr;  ///< of an opaque type, see SnapshotOf
  void (*load)(std::span<const std::byte> bytes, void* value) = nullptr;
  void (*validate)(const void* value) = nullptr;  ///< throws ParameterError; null if there is none

  const TypeInfo& (*item)() = nullptr;  ///< of an opaque type: the struct whose keys its text changes
  std::size_t count = 0;
  void* (*insert)(void* map, const std::string& key) = nullptr;
  void (*clear)(void* map) = nullptr;
  void (*entries)(const void* map, void (*visit)(void* to, const std::string& key, const void* item),
                  void* to) = nullptr;

  /// All numbers in order, if their places inside the object never change (`fixed`).
  std::vector<ScalarRun> runs = {};
  std::size_t num_scalars = 0;
  bool fixed = false;
};

/// The size of a matrix, list or optional that can change.
struct Extents {
  std::size_t rows = 0, cols = 0;
  bool operator==(const Extents&) const = default;
};
inline Extents ExtentsOf(const TypeInfo& type, const void* value) {
  Extents extents;
  type.shape(value, &extents.rows, &extents.cols);
  return extents;
}

/// The first multiple of an alignment from `offset` on.
constexpr std::size_t AlignUp(std::size_t offset, std::size_t alignment) {
  return (offset + alignment - 1) / alignment * alignment;
}

/// The name of a class in C++, from std::type_info::name.
std::string Demangled(const char* name);
/// The type as written in code without namespaces: "LeggedState", "Vec<12>", "Mat<3, 3>",
/// "std::vector<Shape>". X stands for a number of rows or columns that is known only at run time.
std::string TypeName(const TypeInfo& type);

/// A value whose type is known only at run time.
class AnyValue {
 public:
  /// A copy of `model`.
  AnyValue(const TypeInfo& type, const void* model);
  /// A default constructed value, in memory filled with the byte `content`; needs TypeInfo::construct.
  AnyValue(const TypeInfo& type, std::byte content);
  ~AnyValue() { type_.destroy(get()); }
  AnyValue(const AnyValue&) = delete;
  AnyValue& operator=(const AnyValue&) = delete;
  void* get() const { return memory_.get(); }

 private:
  struct Free {
    std::align_val_t alignment;
    void operator()(void* memory) const { ::operator delete(memory, alignment); }
  };
  using Memory = std::unique_ptr<void, Free>;
  static Memory Allocate(const TypeInfo& type);
  const TypeInfo& type_;
  Memory memory_;
};

/// Visits every number in a value, in order; see Walk.
class ValueVisitor {
 public:
  /// Visits the numbers of a matrix, column-major.
  virtual void Numbers(void* data, ScalarKind kind, std::size_t rows, std::size_t cols) = 0;
  virtual void Number(void* data, const TypeInfo& type) { Numbers(data, type.scalar, 1, 1); }
  /// Called before, and Leave after, each member of a struct and each item of a range.
  virtual void EnterMember(const Field& field) { (void)field; }
  virtual void EnterItem(std::size_t index) { (void)index; }
  virtual void Leave() {}
  /// Called before the numbers of a value whose size can change; the visitor may request another size.
  virtual void Resize(std::size_t* rows, std::size_t* cols) { (void)rows, (void)cols; }
  virtual void Text(std::string& text) { (void)text; }
  /// Called before the members of a struct.
  virtual void Struct(const TypeInfo& type) { (void)type; }
  /// Visits a part that does not describe itself.
  virtual void Opaque(const TypeInfo& type, void* value) { (void)type, (void)value; }

 protected:
  ~ValueVisitor() = default;
};

void Walk(const TypeInfo& type, void* value, ValueVisitor& visitor);

/// Sets `info.fields` to the described fields. Throws BuildError if a member of the struct is not listed.
/// `members` is its number of members, see CountMembers; the first one lies at or after `begin` [bytes].
void SetFields(TypeInfo& info, FieldList fields, int members, std::size_t begin);

/// Fills in the runs. Throws BuildError for a struct with a member that `T value;` leaves uninitialised.
TypeInfo WithRuns(TypeInfo info);

template <class T>
struct ItemsOf {
  static constexpr auto kKind = TypeInfo::Kind::kOpaque;
};
template <class T, std::size_t N>
struct ItemsOf<std::array<T, N>> {
  using Item = T;
  static constexpr auto kKind = TypeInfo::Kind::kArray;
  static constexpr std::size_t kCount = N;
};
template <class T>
requires std::is_default_constructible_v<T>
struct ItemsOf<std::vector<T>> {
  using Item = T;
  static constexpr auto kKind = TypeInfo::Kind::kList;
};
template <>
struct ItemsOf<std::vector<bool>> : ItemsOf<void> {};  // its items have no addresses
template <class T>
requires std::is_default_constructible_v<T>
struct ItemsOf<std::optional<T>> {
  using Item = T;
  static constexpr auto kKind = TypeInfo::Kind::kOptional;
};
template <class T>
struct ItemsOf<std::map<std::string, T>> {
  using Item = T;
  static constexpr auto kKind = TypeInfo::Kind::kMap;
};

template <class T>
void DescribeMatrix(TypeInfo& info) {
  static_assert(!T::IsRowMajor || T::IsVectorAtCompileTime, "matrices in signals must be column-major");
  info.kind = TypeInfo::Kind::kMatrix;
  info.scalar = KindOf<typename T::Scalar>();
  info.rows = T::RowsAtCompileTime;
  info.cols = T::ColsAtCompileTime;
  info.data = [](void* value) -> void* { return static_cast<T*>(value)->data(); };
  if constexpr (T::MaxSizeAtCompileTime != Eigen::Dynamic) info.capacity = T::MaxSizeAtCompileTime;
  if constexpr (T::SizeAtCompileTime == Eigen::Dynamic) {
    info.shape = [](const void* value, std::size_t* rows, std::size_t* cols) {
      *rows = static_cast<std::size_t>(static_cast<const T*>(value)->rows());
      *cols = static_cast<std::size_t>(static_cast<const T*>(value)->cols());
    };
    info.resize = [](void* value, std::size_t rows, std::size_t cols) {
      static_cast<T*>(value)->resize(static_cast<Eigen::Index>(rows), static_cast<Eigen::Index>(cols));
    };
  }
}

template <class T>
void DescribeItems(TypeInfo& info) {
  using Items = ItemsOf<T>;
  info.kind = Items::kKind;
  info.item = &TypeInfoOf<typename Items::Item>;
  if constexpr (Items::kKind == TypeInfo::Kind::kArray) {
    info.count = Items::kCount;
  } else if constexpr (Items::kKind == TypeInfo::Kind::kList) {
    info.data = [](void* value) -> void* { return static_cast<T*>(value)->data(); };
    info.shape = [](const void* value, std::size_t* rows, std::size_t* cols) {
      *rows = static_cast<const T*>(value)->size();
      *cols = 1;
    };
    info.resize = [](void* value, std::size_t rows, std::size_t) { static_cast<T*>(value)->resize(rows); };
  } else if constexpr (Items::kKind == TypeInfo::Kind::kOptional) {
    info.data = [](void* value) -> void* { return &**static_cast<T*>(value); };
    info.shape = [](const void* value, std::size_t* rows, std::size_t* cols) {
      *rows = static_cast<const T*>(value)->has_value() ? 1 : 0;
      *cols = 1;
    };
    info.resize = [](void* value, std::size_t rows, std::size_t) {
      rows == 0 ? static_cast<T*>(value)->reset() : static_cast<void>(static_cast<T*>(value)->emplace());
    };
  } else {
    info.insert = [](void* map, const std::string& key) -> void* { return &(*static_cast<T*>(map))[key]; };
    info.clear = [](void* map) { static_cast<T*>(map)->clear(); };
    info.entries = [](const void* map, void (*visit)(void*, const std::string&, const void*), void* to) {
      for (const auto& [key, item] : *static_cast<const T*>(map)) visit(to, key, &item);
    };
  }
}

template <class T>
TypeInfo Describe() {
  TypeInfo info;
  info.id = &typeid(T);
  info.size = sizeof(T);
  info.alignment = alignof(T);
  info.bitwise = kBitwise<T>;
  info.trivial = std::is_trivially_copyable_v<T>;
  if constexpr (std::is_default_constructible_v<T>) {
    info.construct = [](void* at) { new (at) T; };
  }
  info.copy_construct = [](void* at, const void* model) { new (at) T(*static_cast<const T*>(model)); };
  info.destroy = [](void* value) { static_cast<T*>(value)->~T(); };
  info.assign = [](void* to, const void* from) { *static_cast<T*>(to) = *static_cast<const T*>(from); };
  if constexpr (Scalar<T>) {
    info.kind = TypeInfo::Kind::kNumber;
    info.scalar = KindOf<T>();
    if constexpr (NamedEnum<T>) {
      for (const auto& [value, name] : EnumNames(T{})) {
        info.names.push_back({static_cast<long long>(value), name});
      }
    }
  } else if constexpr (EigenMatrix<T>) {
    DescribeMatrix<T>(info);
  } else if constexpr (HasFields<T>) {
    info.kind = TypeInfo::Kind::kStruct;
    SetFields(info, T::Fields(), CountMembers<T>(),
              std::is_empty_v<T>         ? sizeof(T)
              : std::is_polymorphic_v<T> ? sizeof(void*)
                                         : 0);
    if constexpr (requires(const T& value) { value.Validate(); }) {
      info.validate = [](const void* value) { static_cast<const T*>(value)->Validate(); };
    }
  } else if constexpr (std::is_same_v<T, std::string>) {
    info.kind = TypeInfo::Kind::kText;
  } else if constexpr (ItemsOf<T>::kKind != TypeInfo::Kind::kOpaque) {
    DescribeItems<T>(info);
  } else if constexpr (requires { typename T::Changed; }) {
    info.item = &TypeInfoOf<typename T::Changed>;
    info.count = T::kHasScale ? 1 : 0;
  } else if constexpr (requires { SnapshotOf<T>::Save; }) {
    info.save = [](const void* value) { return SnapshotOf<T>::Save(*static_cast<const T*>(value)); };
    info.load = [](std::span<const std::byte> bytes, void* value) {
      SnapshotOf<T>::Load(bytes, *static_cast<T*>(value));
    };
  }
  return info;
}

/// The single description of a type. Shipped signals are described once, see TENON_DECLARE_SIGNAL.
template <class T>
const TypeInfo& TypeInfoOf() {
  static const TypeInfo kInfo = WithRuns(Describe<T>());
  return kInfo;
}

}  // namespace tenon::internal

/// Optional: describes a type that many files use in a single translation unit, to shorten compilation. Put
/// TENON_DECLARE_SIGNAL(tenon::LeggedState) below the struct and outside of any namespace, and
/// TENON_DEFINE_SIGNAL in a .cc.
#define TENON_DECLARE_SIGNAL(...) \
  extern template const ::tenon::internal::TypeInfo& ::tenon::internal::TypeInfoOf<__VA_ARGS__>()
#define TENON_DEFINE_SIGNAL(...) \
  template const ::tenon::internal::TypeInfo& ::tenon::internal::TypeInfoOf<__VA_ARGS__>()

TENON_DECLARE_SIGNAL(bool);
TENON_DECLARE_SIGNAL(int);
TENON_DECLARE_SIGNAL(double);
TENON_DECLARE_SIGNAL(std::uint64_t);
TENON_DECLARE_SIGNAL(std::string);
TENON_DECLARE_SIGNAL(std::vector<double>);
TENON_DECLARE_SIGNAL(std::vector<std::string>);
TENON_DECLARE_SIGNAL(Eigen::Vector3d);
TENON_DECLARE_SIGNAL(Eigen::Matrix3d);
TENON_DECLARE_SIGNAL(Eigen::VectorXd);
TENON_DECLARE_SIGNAL(Eigen::Matrix<double, 2, 1, Eigen::DontAlign>);
TENON_DECLARE_SIGNAL(Eigen::Matrix<double, 4, 1, Eigen::DontAlign>);
TENON_DECLARE_SIGNAL(Eigen::Matrix<double, 6, 1, Eigen::DontAlign>);
TENON_DECLARE_SIGNAL(Eigen::Matrix<double, 12, 1, Eigen::DontAlign>);
