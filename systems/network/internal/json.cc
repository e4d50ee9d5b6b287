#include <tenon/systems/network/internal/json.h>
#include <tenon/systems/text/text.h>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <algorithm>

namespace tenon::internal {
namespace {

/// Space for the longest number, "-2.2250738585072014e-308" [characters].
constexpr std::size_t kLongestNumber = 32;

/// Compares the sizes of matrices and lists with recorded ones and records them.
class ShapeVisitor final : public ValueVisitor {
 public:
  explicit ShapeVisitor(std::vector<std::size_t>& shape) : shape_(shape) {}
  void Numbers(void*, ScalarKind, std::size_t, std::size_t) override {}
  void Resize(std::size_t* rows, std::size_t* cols) override {
    for (const std::size_t extent : {*rows, *cols}) {
      if (count_ == shape_.size()) shape_.push_back(extent + 1);  // differs from extent
      changed_ = changed_ || shape_[count_] != extent;
      shape_[count_++] = extent;
    }
  }
  bool Finish() {
    changed_ = changed_ || count_ != shape_.size();
    shape_.resize(count_);
    return changed_;
  }

 private:
  std::vector<std::size_t>& shape_;
  std::size_t count_ = 0;
  bool changed_ = false;
};

char* Append(char* out, std::string_view text) {
  return std::copy(text.begin(), text.end(), out);
}

template <class Number>
char* AppendNumber(char* out, Number number) {
  if constexpr (std::is_same_v<Number, bool>) {
    return Append(out, number ? "true" : "false");
  } else {
    if constexpr (std::is_floating_point_v<Number>) {
      if (std::isnan(number)) return Append(out, "\"NaN\"");
      if (std::isinf(number)) return Append(out, number > 0 ? "\"Infinity\"" : "\"-Infinity\"");
      if (number == 0 && std::signbit(number))
        return Append(out, "-0.0");  // "-0" would be read as an integer
    }
    return std::to_chars(out, out + kLongestNumber, number).ptr;
  }
}

class NumberWriter final : public ValueVisitor {
 public:
  NumberWriter(char* out, const std::string* piece) : out_(out), piece_(piece) {}
  void Numbers(void* data, ScalarKind kind, std::size_t rows, std::size_t cols) override {
    WithKind(kind, data, [&](const auto* numbers) {
      for (std::size_t i = 0; i < rows * cols; ++i) out_ = AppendNumber(Append(out_, *piece_++), numbers[i]);
    });
  }
  char* out() const { return out_; }

 private:
  char* out_;
  const std::string* piece_;
};

class KindVisitor final : public ValueVisitor {
 public:
  KindVisitor(std::vector<ScalarKind>& kinds, std::vector<const TypeInfo*>& enumerations)
      : kinds_(kinds), enumerations_(enumerations) {}
  void Number(void*, const TypeInfo& type) override {
    kinds_.push_back(type.scalar);
    enumerations_.push_back(type.names.empty() ? nullptr : &type);
  }
  void Numbers(void*, ScalarKind kind, std::size_t rows, std::size_t cols) override {
    kinds_.insert(kinds_.end(), rows * cols, kind);
    enumerations_.resize(kinds_.size());
  }

 private:
  std::vector<ScalarKind>& kinds_;
  std::vector<const TypeInfo*>& enumerations_;
};

template <class Element>
Element To(const JsonNumber& number) {
  return std::visit([](auto value) { return static_cast<Element>(value); }, number);
}

class NumberStore final : public ValueVisitor {
 public:
  explicit NumberStore(const JsonNumber* next) : next_(next) {}
  void Numbers(void* data, ScalarKind kind, std::size_t rows, std::size_t cols) override {
    WithKind(kind, data, [&]<class Element>(Element* elements) {
      for (std::size_t i = 0; i < rows * cols; ++i) elements[i] = To<Element>(*next_++);
    });
  }

 private:
  const JsonNumber* next_;
};

}  // namespace

std::vector<std::string> JsonKeys(const std::string& name, const TypeInfo& type, const void* value,
                                  const Spec& spec) {
  std::vector<std::string> keys;
  for (const Element& element : ListElements(type, value, spec)) keys.push_back(element.PathIn(name));
  return keys;
}

void JsonWriter::Prepare(const std::string& name, const TypeInfo& type, const void* value, const Spec& spec) {
  pieces_.assign(1, fmt::format("{{\"{}\":", kJsonTimestamp));
  std::vector<std::string> open;  // names of the enclosing objects
  std::size_t size = pieces_[0].size();
  for (const std::string& key : JsonKeys(name, type, value, spec)) {
    std::vector<std::string> parts;
    Split(key, '.', [&](std::string_view part) { parts.emplace_back(part); });
    const std::string last = parts.back();
    parts.pop_back();
    std::size_t common = 0;
    while (common < open.size() && common < parts.size() && open[common] == parts[common]) ++common;
    std::string piece(open.size() - common, '}');
    piece += ',';
    for (std::size_t i = common; i < parts.size(); ++i) piece += nlohmann::json(parts[i]).dump() + ":{";
    pieces_.push_back(piece + nlohmann::json(last).dump() + ':');
    open = std::move(parts);
    size += pieces_.back().size();
  }
  pieces_.emplace_back(open.size() + 1, '}');
  text_.resize(size + pieces_.back().size() + kLongestNumber * pieces_.size());
}

std::span<const char> JsonWriter::Write(double time, const std::string& name, const TypeInfo& type,
                                        const void* value, const Spec& spec) {
  auto* numbers = const_cast<void*>(value);
  bool prepared = !pieces_.empty();
  if (!type.fixed) {
    ShapeVisitor shape(shape_);
    Walk(type, numbers, shape);
    if (shape.Finish()) prepared = false;
  }
  if (!prepared) Prepare(name, type, value, spec);
  NumberWriter writer(AppendNumber(Append(text_.data(), pieces_[0]), time), &pieces_[1]);
  Walk(type, numbers, writer);
  const char* end = Append(writer.out(), pieces_.back());
  return {text_.data(), static_cast<std::size_t>(end - text_.data())};
}

/// Handles the parser events of nlohmann_json for a message; returning false stops the parser.
class JsonReader::Handler {
 public:
  explicit Handler(JsonReader& reader) : reader_(reader) {}

  bool null() { return Refuse("'{}' is null", path_); }
  bool boolean(bool value) { return Take(value); }
  bool number_integer(std::int64_t value) { return Take(value); }
  bool number_unsigned(std::uint64_t value) { return Take(value); }
  bool number_float(double value, const std::string&) { return Take(value); }
  bool string(std::string&) { return Refuse("'{}' is a text, not a number", path_); }
  bool binary(std::vector<std::uint8_t>&) { return false; }  // does not occur in JSON
  bool start_object(std::size_t) {
    lengths_.push_back(path_.size());
    return true;
  }
  bool key(std::string& name) {
    path_.resize(lengths_.back());
    if (!path_.empty()) path_ += '.';
    path_ += name;
    return true;
  }
  bool end_object() {
    path_.resize(lengths_.back());
    lengths_.pop_back();
    return true;
  }
  bool start_array(std::size_t) { return Refuse("'{}' is a list, not a number", path_); }
  bool end_array() { return true; }
  bool parse_error(std::size_t place, const std::string&, const nlohmann::json::exception&) {
    return Refuse("invalid JSON before byte {}", place);
  }
  std::string reason;

 private:
  template <class... Args>
  bool Refuse(fmt::format_string<Args...> format, Args&&... args) {
    reason = fmt::format(format, std::forward<Args>(args)...);
    return false;
  }

  template <class T>
  bool Take(T number) {
    if (lengths_.empty()) return Refuse("the message is not a JSON object");
    // Most messages have their keys in the order of the signal, which avoids the look-up.
    if (next_ == reader_.names_.size() || reader_.names_[next_] != path_) {
      const auto found = reader_.places_.find(path_);
      if (found == reader_.places_.end()) return Refuse("the signal has no element '{}'", path_);
      next_ = found->second;
    }
    const std::size_t i = next_++;
    if (reader_.given_[i]) return Refuse("'{}' is given twice", path_);
    if (!Fits(number, reader_.kinds_[i]))
      return Refuse("'{}' = {} does not fit the type of its element", path_, number);
    if (const TypeInfo* type = reader_.enumerations_[i]; type != nullptr && !IsNamedBy(*type, number))
      return Refuse("'{}' = {} must be one of {}", path_, number, NamedValues(*type));
    reader_.given_[i] = true;
    reader_.numbers_[i] = number;
    return true;
  }

  /// Returns whether an element of that kind can represent the number exactly.
  template <class T>
  static bool Fits(T number, ScalarKind kind) {
    bool fits = false;
    WithKind(kind, nullptr, [&]<class Element>(Element*) {
      if constexpr (std::is_same_v<Element, double> || std::is_same_v<T, bool>) {
        fits = true;
      } else if constexpr (std::is_same_v<Element, float>) {
        const auto size = std::abs(static_cast<double>(number));
        fits = !(size > std::numeric_limits<float>::max()) || std::isinf(size);
      } else if constexpr (std::is_same_v<Element, bool>) {
        fits = number == 0 || number == 1;
      } else if constexpr (std::is_same_v<T, double>) {
        fits = number == std::floor(number) && std::abs(number) <= 9007199254740992.0 &&
               std::in_range<Element>(static_cast<std::int64_t>(number));
      } else {
        fits = std::in_range<Element>(number);
      }
    });
    return fits;
  }

  template <class T>
  static bool IsNamedBy(const TypeInfo& type, T number) {
    std::uint64_t value = 0;
    StoreInteger(type.scalar, &value, static_cast<long long>(number));
    return IsNamed(type, &value);
  }

  JsonReader& reader_;
  std::string path_;
  std::vector<std::size_t> lengths_;  ///< lengths of the paths to the enclosing objects
  std::size_t next_ = 0;
};

JsonReader::JsonReader(std::string name, const TypeInfo& type, const void* model, const Spec& spec)
    : type_(type), names_(JsonKeys(name, type, model, spec)) {
  KindVisitor kinds(kinds_, enumerations_);
  Walk(type, const_cast<void*>(model), kinds);
  names_.emplace_back(kJsonTimestamp);
  kinds_.push_back(ScalarKind::kDouble);
  enumerations_.push_back(nullptr);
  for (std::size_t i = 0; i < names_.size(); ++i) places_.emplace(names_[i], i);
  numbers_.resize(names_.size());
}

std::string JsonReader::Read(std::span<const char> message, double* timestamp, void* value) {
  given_.assign(names_.size(), false);
  Handler handler(*this);
  if (!nlohmann::json::sax_parse(message.begin(), message.end(), &handler)) return handler.reason;
  for (std::size_t i = 0; i < given_.size(); ++i) {
    if (!given_[i]) return fmt::format("'{}' is missing", names_[i]);
  }
  NumberStore store(numbers_.data());
  Walk(type_, value, store);
  *timestamp = To<double>(numbers_.back());
  return "";
}

}  // namespace tenon::internal
