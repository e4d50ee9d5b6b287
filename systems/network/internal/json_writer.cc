#include <tenon/systems/network/internal/json_writer.h>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <charconv>
#include <string_view>

namespace tenon::internal {
namespace {

/// Space for the longest number, "-2.2250738585072014e-308" [characters].
constexpr std::size_t kLongestNumber = 32;

std::vector<std::string> Split(const std::string& name) {
  std::vector<std::string> parts;
  std::size_t begin = 0;
  for (std::size_t dot; (dot = name.find('.', begin)) != std::string::npos; begin = dot + 1) {
    parts.push_back(name.substr(begin, dot - begin));
  }
  parts.push_back(name.substr(begin));
  return parts;
}

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

}  // namespace

std::vector<std::string> JsonKeys(const std::string& name, const TypeInfo& type, const void* value,
                                  const Spec& spec) {
  std::vector<std::string> keys;
  for (const Element& element : ListElements(type, value, spec)) {
    keys.push_back(element.name.empty() ? name : name + "." + element.name);
  }
  return keys;
}

void JsonWriter::Prepare(const std::string& name, const TypeInfo& type, const void* value, const Spec& spec) {
  pieces_.assign(1, fmt::format("{{\"{}\":", kJsonTimestamp));
  std::vector<std::string> open;  // names of the enclosing objects
  std::size_t size = pieces_[0].size();
  for (const std::string& key : JsonKeys(name, type, value, spec)) {
    std::vector<std::string> parts = Split(key);
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

}  // namespace tenon::internal
