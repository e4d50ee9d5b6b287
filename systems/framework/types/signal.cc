#include <tenon/systems/framework/types/diagonal_gains.h>
#include <tenon/systems/text/text.h>

#include <fmt/core.h>

#include <algorithm>

namespace tenon {

Spec::Spec(const char* name) : name(name) {}
Spec::Spec(std::string name, std::string units, std::string elements)
    : name(std::move(name)), units(std::move(units)), elements(std::move(elements)) {}

DiagonalGains& DiagonalGains::operator*=(double factor) {
  for (double& value : values_) value *= factor;
  return *this;
}

void DiagonalGains::CheckSize(const char* name, int count, const char* elements) const {
  if (size() != 1 && size() != static_cast<std::size_t>(count))
    throw ParameterError(
        fmt::format("{}: it has {} numbers for {} {}; give one number for each, or a single one for all",
                    name, size(), count, elements));
}

namespace internal {
namespace {

/// The `index`-th entry of a comma-separated list, trimmed; empty if there is none.
std::string ListEntry(const std::string& list, std::size_t index) {
  std::string_view entry;
  Split(list, ',', [&](std::string_view each) {
    if (index-- == 0) entry = each;
  });
  return std::string(Trimmed(entry));
}

/// Name of a matrix element: from the spec, else x, y, z for three rows, else its index.
std::string ElementName(const Spec& spec, std::size_t row, std::size_t col, std::size_t rows,
                        std::size_t cols) {
  if (cols > 1) return std::to_string(row) + "_" + std::to_string(col);
  if (const std::string name = ListEntry(spec.elements, row); !name.empty()) return name;
  if (rows == 3) return std::string(1, "xyz"[row]);
  return std::to_string(row);
}

bool IsReal(ScalarKind kind) {
  return kind == ScalarKind::kDouble || kind == ScalarKind::kFloat;
}

class ElementLister final : public ValueVisitor {
 public:
  explicit ElementLister(const Spec& spec) : specs_{spec} {}
  void Number(void*, const TypeInfo& type) override {
    elements.push_back({path_, specs_.back().units, IsReal(type.scalar)});
  }
  void Numbers(void*, ScalarKind kind, std::size_t rows, std::size_t cols) override {
    const Spec& spec = specs_.back();
    for (std::size_t c = 0; c < cols; ++c) {
      for (std::size_t r = 0; r < rows; ++r) {
        elements.push_back(
            {Below(ElementName(spec, r, c, rows, cols)), ElementUnit(spec, c * rows + r), IsReal(kind)});
      }
    }
  }
  void EnterMember(const Field& field) override {
    Enter(Spec(field.name, field.units, field.elements), field.name);
  }
  void EnterItem(std::size_t index) override {
    const std::string name = ListEntry(specs_.back().elements, index);
    Enter(Spec(specs_.back().name, specs_.back().units), name.empty() ? std::to_string(index) : name);
  }
  void Leave() override {
    specs_.pop_back();
    path_.resize(lengths_.back());
    lengths_.pop_back();
  }
  std::vector<Element> elements;

 private:
  std::string Below(const std::string& name) const { return path_.empty() ? name : path_ + "." + name; }
  void Enter(Spec spec, const std::string& name) {
    specs_.push_back(std::move(spec));
    lengths_.push_back(path_.size());
    path_ = Below(name);
  }
  std::vector<Spec> specs_;
  std::vector<std::size_t> lengths_;  ///< lengths of the enclosing paths
  std::string path_;
};

/// Calls function(data, kind, count) for every run of numbers of one kind.
template <class Function>
class RunVisitor final : public ValueVisitor {
 public:
  explicit RunVisitor(Function function) : function_(std::move(function)) {}
  void Numbers(void* data, ScalarKind kind, std::size_t rows, std::size_t cols) override {
    function_(data, kind, rows * cols);
  }

 private:
  Function function_;
};

template <class Function>
void ForEachRun(const TypeInfo& type, const void* value, Function function) {
  auto* bytes = static_cast<std::byte*>(const_cast<void*>(value));
  if (type.fixed) {
    for (const ScalarRun& run : type.runs) function(bytes + run.offset, run.kind, run.count);
  } else {
    RunVisitor<Function> visitor(std::move(function));
    Walk(type, bytes, visitor);
  }
}

/// True if an element of type T can represent the number.
template <class T>
bool CanHold(double number) {
  using Limits = std::numeric_limits<T>;
  if constexpr (std::is_same_v<T, double>) {
    return true;
  } else if constexpr (std::is_same_v<T, float>) {
    return !(std::abs(number) > Limits::max()) || std::isinf(number);
  } else {
    constexpr double kEnd = 2.0 * static_cast<double>(Limits::max() / 2 + 1);  // a double may not hold max()
    return number == std::floor(number) && number >= static_cast<double>(Limits::min()) && number < kEnd;
  }
}

template <class T>
std::string WhatItHolds() {
  if constexpr (std::is_floating_point_v<T>) return "a number in the range of single precision";
  if constexpr (std::is_same_v<T, bool>) return "0 or 1";
  return fmt::format("a whole number from {} to {}", std::numeric_limits<T>::min(),
                     std::numeric_limits<T>::max());
}

class DoubleReader final : public ValueVisitor {
 public:
  DoubleReader(const TypeInfo& type, const void* value, const double* in)
      : type_(type), value_(value), in_(in) {}
  void Number(void* data, const TypeInfo& type) override {
    if (type.names.empty()) return Numbers(data, type.scalar, 1, 1);
    WithKind(type.scalar, data, [&]<class T>(T* number) {
      const T before = *number;
      if (!Store(number) || (*number != before && !IsNamed(type, number))) Refuse(NamedValues(type));
    });
    ++count_;
  }
  void Numbers(void* data, ScalarKind kind, std::size_t rows, std::size_t cols) override {
    WithKind(kind, data, [&]<class T>(T* first) {
      for (T* each = first; each != first + rows * cols; ++each) {
        if (!Store(each)) Refuse(WhatItHolds<T>());
        ++count_;
      }
    });
  }

 private:
  /// True if the element can represent the number. An integer that already has this value is accepted,
  /// whatever it is.
  template <class T>
  bool Store(T* element) const {
    const double number = in_[count_];
    if (!std::is_floating_point_v<T> && static_cast<double>(*element) == number) return true;
    if (!CanHold<T>(number)) return false;
    *element = static_cast<T>(number);
    return true;
  }
  [[noreturn]] void Refuse(const std::string& allowed) const {
    const std::string name = ListElements(type_, value_, "")[count_].name;
    throw NumberError(fmt::format("{} cannot be {}: give {}", name.empty() ? "it" : "'" + name + "'",
                                  in_[count_], allowed));
  }
  const TypeInfo& type_;
  const void* value_;
  const double* in_;
  std::size_t count_ = 0;
};

[[noreturn]] void ThrowOpaque(const TypeInfo& type) {
  throw Error(fmt::format(
      "{} does not describe itself: give it a static Fields(), or specialise SnapshotOf to make it storable",
      TypeName(type)));
}

class Saver final : public ValueVisitor {
 public:
  Saver(Archive& archive, bool whole) : archive_(archive), whole_(whole) {}
  void Struct(const TypeInfo& type) override {
    if (!whole_ || !type.omits) return;
    throw Error(
        fmt::format("{} has Undescribed members, of which Restore would keep the values of the future: "
                    "describe them, or let them point to constant data",
                    TypeName(type)));
  }
  void Numbers(void* data, ScalarKind kind, std::size_t rows, std::size_t cols) override {
    archive_.Write(data, SizeOf(kind) * rows * cols);
  }
  void Resize(std::size_t* rows, std::size_t* cols) override {
    Save(*rows, archive_);
    Save(*cols, archive_);
  }
  void Text(std::string& text) override {
    Save(text.size(), archive_);
    archive_.Write(text.data(), text.size());
  }
  void Opaque(const TypeInfo& type, void* value) override {
    if (type.save == nullptr) ThrowOpaque(type);
    const std::vector<std::byte> bytes = type.save(value);
    Save(bytes.size(), archive_);
    archive_.Write(bytes.data(), bytes.size());
  }

 private:
  Archive& archive_;
  bool whole_;
};

class Loader final : public ValueVisitor {
 public:
  explicit Loader(Archive& archive) : archive_(archive) {}
  void Numbers(void* data, ScalarKind kind, std::size_t rows, std::size_t cols) override {
    if (kind != ScalarKind::kBool) return archive_.Read(data, SizeOf(kind) * rows * cols);
    for (std::size_t i = 0; i < rows * cols; ++i) Load(static_cast<bool*>(data)[i], archive_);
  }
  void Number(void* data, const TypeInfo& type) override {
    Numbers(data, type.scalar, 1, 1);
    if (IsNamed(type, data)) return;
    throw RunError("the snapshot is damaged: an enumeration has a value without a name");
  }
  void Resize(std::size_t* rows, std::size_t* cols) override {
    Load(*rows, archive_);
    Load(*cols, archive_);
    if (*rows == 0 || *cols == 0) return;  // no bytes follow
    // Every item takes at least one byte; checking the rows first keeps the product from overflowing.
    archive_.Demand(*rows);
    archive_.Demand(*cols);
    archive_.Demand(*rows * *cols);
  }
  void Text(std::string& text) override {
    std::size_t size = 0;
    Load(size, archive_);
    archive_.Demand(size);  // a damaged size must not allocate all memory
    text.resize(size);
    archive_.Read(text.data(), text.size());
  }
  void Opaque(const TypeInfo& type, void* value) override {
    if (type.load == nullptr) ThrowOpaque(type);
    std::size_t size = 0;
    Load(size, archive_);
    archive_.Demand(size);
    std::vector<std::byte> bytes(size);
    archive_.Read(bytes.data(), size);
    type.load(bytes, value);
  }

 private:
  Archive& archive_;
};

}  // namespace

std::size_t ListLength(const std::string& list) {
  if (list.empty()) return 0;
  return 1 + static_cast<std::size_t>(std::count(list.begin(), list.end(), ','));
}

Spec Completed(Spec spec, const Spec& other) {
  if (spec.name.empty()) spec.name = other.name;
  if (spec.units.empty()) spec.units = other.units;
  if (spec.elements.empty()) spec.elements = other.elements;
  return spec;
}

std::string ElementUnit(const Spec& spec, std::size_t index) {
  return spec.units.find(',') == std::string::npos ? spec.units : ListEntry(spec.units, index);
}

std::vector<Element> ListElements(const TypeInfo& type, const void* value, const Spec& spec) {
  ElementLister lister(spec);
  Walk(type, const_cast<void*>(value), lister);
  return std::move(lister.elements);
}

std::size_t CountScalars(const TypeInfo& type, const void* value) {
  if (type.fixed) return type.num_scalars;
  if (type.kind == TypeInfo::Kind::kMatrix) {  // quickly, because each evaluation of derivatives counts
    const Extents shape = ExtentsOf(type, value);
    return shape.rows * shape.cols;
  }
  std::size_t count = 0;
  ForEachRun(type, value, [&](const void*, ScalarKind, std::size_t size) { count += size; });
  return count;
}

double* ToDoubles(const TypeInfo& type, const void* value, double* out) {
  ForEachRun(type, value, [&](void* data, ScalarKind kind, std::size_t count) {
    WithKind(kind, data, [&](const auto* first) { out = std::copy(first, first + count, out); });
  });
  return out;
}

std::vector<double> DoublesOf(const TypeInfo& type, const void* value) {
  std::vector<double> numbers(CountScalars(type, value));
  ToDoubles(type, value, numbers.data());
  return numbers;
}

void FromDoubles(const TypeInfo& type, void* value, const double* in) {
  const auto is_double = [](const ScalarRun& run) { return run.kind == ScalarKind::kDouble; };
  if (type.fixed && std::ranges::all_of(type.runs, is_double)) {
    for (const ScalarRun& run : type.runs) {
      std::copy_n(in, run.count, reinterpret_cast<double*>(static_cast<std::byte*>(value) + run.offset));
      in += run.count;
    }
    return;
  }
  DoubleReader reader(type, value, in);
  Walk(type, value, reader);
}

bool IsNamed(const TypeInfo& type, const void* value) {
  return type.names.empty() ||
         std::ranges::count(type.names, LoadInteger(type.scalar, value), &NamedValue::value) > 0;
}

std::string NamedValues(const TypeInfo& type) {
  std::string list;
  for (const auto& [value, name] : type.names)
    list += fmt::format("{}{} ({})", list.empty() ? "" : ", ", value, name);
  return list;
}

Finiteness FinitenessOf(const TypeInfo& type, const void* value) {
  Finiteness worst = Finiteness::kFinite;
  ForEachRun(type, value, [&](void* data, ScalarKind kind, std::size_t count) {
    if (!IsReal(kind)) return;
    WithKind(kind, data, [&](const auto* first) {
      if (AllFinite(first, count)) return;
      for (std::size_t i = 0; i < count; ++i) {
        if (std::isnan(first[i])) worst = Finiteness::kNan;
      }
      if (worst == Finiteness::kFinite) worst = Finiteness::kInfinite;
    });
  });
  return worst;
}

void SetZero(const TypeInfo& type, void* value) {
  ForEachRun(type, value, [&](void* data, ScalarKind kind, std::size_t count) {
    if (count > 0) std::memset(data, 0, SizeOf(kind) * count);  // an empty matrix has no data
  });
}

void Archive::Write(const void* data, std::size_t size) {
  const auto* bytes = static_cast<const std::byte*>(data);
  bytes_.insert(bytes_.end(), bytes, bytes + size);
}

void Archive::Demand(std::size_t size) const {
  if (size <= bytes_.size() - cursor_) return;
  throw RunError("the snapshot is truncated after " + std::to_string(bytes_.size()) + " bytes");
}

void Archive::Read(void* data, std::size_t size) {
  Demand(size);
  if (size == 0) return;  // an empty matrix has no data
  std::memcpy(data, bytes_.data() + cursor_, size);
  cursor_ += size;
}

void Load(bool& value, Archive& archive) {
  std::uint8_t byte = 0;
  archive.Read(&byte, sizeof(byte));
  if (byte > 1) throw RunError("the snapshot is damaged: a bool is neither 0 nor 1");
  value = byte == 1;
}

void Save(const TypeInfo& type, const void* value, Archive& archive, bool whole) {
  Saver saver(archive, whole);
  Walk(type, const_cast<void*>(value), saver);
}

void Load(const TypeInfo& type, void* value, Archive& archive) {
  Loader loader(archive);
  Walk(type, value, loader);
}

}  // namespace internal
}  // namespace tenon
