#include <tenon/systems/framework/block/rate.h>
#include <tenon/systems/framework/types/diagonal_gains.h>
#include <tenon/systems/yaml/internal/yaml_tree.h>
#include <tenon/systems/yaml/yaml.h>

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <cctype>

namespace tenon::internal {
namespace {

/// Returns whether every YAML reader takes an unquoted text for text.
bool IsPlainText(const std::string& text) {
  const auto is_word = [](unsigned char c) { return std::isalnum(c) || c == '_'; };
  const auto is_plain = [&](unsigned char c) {
    return is_word(c) || c == ' ' || c == '.' || c == '/' || c == '-';
  };
  constexpr const char* kReserved[] = {"null", "true", "false", "yes", "no", "on", "off", "y", "n"};
  std::string lower = text;
  std::transform(lower.begin(), lower.end(), lower.begin(), [](unsigned char c) { return std::tolower(c); });
  return !text.empty() && std::isalpha(static_cast<unsigned char>(text.front())) && text.back() != ' ' &&
         std::all_of(text.begin(), text.end(), is_plain) && std::ranges::count(kReserved, lower) == 0;
}

class Writer {
 public:
  Writer() { emitter_.SetNullFormat(YAML::LowerNull); }
  std::string Text() const { return std::string(emitter_.c_str()) + "\n"; }

  void Write(const TypeInfo& type, const void* value) {
    switch (type.kind) {
      case TypeInfo::Kind::kNumber:
        return WriteNumber(type, value);
      case TypeInfo::Kind::kText:
        return Emit(*static_cast<const std::string*>(value));
      case TypeInfo::Kind::kMatrix:
        return WriteMatrix(type, value);
      case TypeInfo::Kind::kStruct:
        emitter_ << YAML::BeginMap;
        for (const Field& field : type.fields) {
          WriteKey(field.name);
          Write(field.type(), static_cast<const std::byte*>(value) + field.offset);
        }
        emitter_ << YAML::EndMap;
        return;
      case TypeInfo::Kind::kArray:
        return WriteItems(type.item(), value, type.count);
      case TypeInfo::Kind::kList:
        if (*type.id == typeid(DiagonalGains) && ExtentsOf(type, value).rows == 1)
          return Write(type.item(), type.data(const_cast<void*>(value)));
        return WriteItems(type.item(), type.data(const_cast<void*>(value)), ExtentsOf(type, value).rows);
      case TypeInfo::Kind::kOptional:
        if (ExtentsOf(type, value).rows > 0) return Write(type.item(), type.data(const_cast<void*>(value)));
        emitter_ << YAML::Null;
        return;
      case TypeInfo::Kind::kMap:
        return WriteMap(type, value);
      case TypeInfo::Kind::kOpaque:
        if (*type.id == typeid(YamlText) || type.item != nullptr) {
          const std::string& text = static_cast<const YamlText*>(value)->text;
          emitter_ << YAML::Load(text.empty() ? "{}" : text);
          return;
        }
        if (*type.id == typeid(Rate)) return WriteDouble(static_cast<const Rate*>(value)->hz());
        if (*type.id == typeid(YamlFile)) {
          emitter_ << YAML::Load(static_cast<const YamlFile*>(value)->text);
          return;
        }
        Fail("its type has no YAML form: a struct needs a static Fields(), an enum EnumNames()");
    }
  }

 private:
  [[noreturn]] void Fail(const std::string& what) const {
    throw ParameterError(fmt::format("{}: {}", key_, what));
  }

  void WriteNumber(const TypeInfo& type, const void* value) {
    if (type.scalar == ScalarKind::kDouble) return WriteDouble(*static_cast<const double*>(value));
    if (type.scalar == ScalarKind::kBool) {
      emitter_ << *static_cast<const bool*>(value);
      return;
    }
    if (type.scalar == ScalarKind::kFloat) Fail("its type has no YAML form: use double");
    const long long integer = LoadInteger(type.scalar, value);
    if (type.names.empty()) {
      emitter_ << (type.scalar == ScalarKind::kUint64
                       ? fmt::format("{}", static_cast<unsigned long long>(integer))
                       : fmt::format("{}", integer));
      return;
    }
    for (const NamedValue& named : type.names) {
      if (named.value == integer) return Emit(named.name);
    }
    Fail(fmt::format("the value {} has no name; name it in EnumNames()", integer));
  }

  void WriteDouble(double value) {
    if (!std::isfinite(value))
      Fail(fmt::format("{} cannot be written to YAML; parameters must be finite numbers", value));
    emitter_ << fmt::format("{}", value);
  }

  /// A vector as a list, a matrix as a list of rows.
  void WriteMatrix(const TypeInfo& type, const void* value) {
    if (type.rows < 1 || type.cols < 1 || type.scalar != ScalarKind::kDouble)
      Fail("its type has no YAML form: only vectors and matrices of doubles and of fixed size have one");
    const auto* numbers = static_cast<const double*>(type.data(const_cast<void*>(value)));
    emitter_ << YAML::Flow << YAML::BeginSeq;
    for (int r = 0; r < type.rows; ++r) {
      if (type.cols > 1) emitter_ << YAML::Flow << YAML::BeginSeq;
      for (int c = 0; c < type.cols; ++c) WriteDouble(numbers[c * type.rows + r]);
      if (type.cols > 1) emitter_ << YAML::EndSeq;
    }
    emitter_ << YAML::EndSeq;
  }

  void WriteItems(const TypeInfo& item, const void* first, std::size_t count) {
    emitter_ << (item.kind == TypeInfo::Kind::kStruct ? YAML::Block : YAML::Flow) << YAML::BeginSeq;
    for (std::size_t i = 0; i < count; ++i) {
      Write(item, static_cast<const std::byte*>(first) + i * item.size);
    }
    emitter_ << YAML::EndSeq;
  }

  void WriteMap(const TypeInfo& type, const void* value) {
    bool empty = true;
    type.entries(
        value, [](void* to, const std::string&, const void*) { *static_cast<bool*>(to) = false; }, &empty);
    if (empty) emitter_ << YAML::Flow;
    emitter_ << YAML::BeginMap;
    struct Target {
      Writer* writer;
      const TypeInfo* item;
    } target{this, &type.item()};
    type.entries(
        value,
        [](void* to, const std::string& key, const void* item) {
          const auto& [writer, item_type] = *static_cast<Target*>(to);
          writer->WriteKey(key);
          writer->Write(*item_type, item);
        },
        &target);
    emitter_ << YAML::EndMap;
  }

  void WriteKey(const std::string& key) {
    key_ = key;
    emitter_ << YAML::Key;
    Emit(key);
    emitter_ << YAML::Value;
  }

  void Emit(const std::string& text) {
    if (IsPlainText(text)) {
      emitter_ << text;
    } else {
      emitter_ << YAML::DoubleQuoted << text;
    }
  }

  YAML::Emitter emitter_;
  std::string key_ = "value";  ///< the last key written, for messages
};

}  // namespace

/// Writes block-style YAML with lists in flow style and the shortest numbers that read back exactly. Throws
/// ParameterError for a value that could not be read back.
std::string WriteYaml(const TypeInfo& type, const void* value) {
  Writer writer;
  writer.Write(type, value);
  return writer.Text();
}

std::string YamlScalar(const std::string& text) {
  std::string line = WriteYaml(TypeInfoOf<std::string>(), &text);
  line.pop_back();  // newline
  return line;
}

}  // namespace tenon::internal
