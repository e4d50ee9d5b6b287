#include <tenon/systems/yaml/yaml_writer.h>

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include <tenon/systems/framework/errors.h>

namespace tenon::internal {
namespace {

/// Words that no reader of YAML takes for anything but text.
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

}  // namespace

struct YamlWriter::Impl {
  YAML::Emitter emitter;
  std::string key = "value";  // the last key written, for messages

  void Emit(const std::string& text) {
    if (IsPlainText(text)) {
      emitter << text;
    } else {
      emitter << YAML::DoubleQuoted << text;
    }
  }
};

YamlWriter::YamlWriter() : impl_(std::make_unique<Impl>()) {
  impl_->emitter.SetNullFormat(YAML::LowerNull);
}
YamlWriter::~YamlWriter() = default;

std::string YamlWriter::Text() const {
  return std::string(impl_->emitter.c_str()) + "\n";
}

void YamlWriter::Write(double value) {
  if (!std::isfinite(value))
    throw ParameterError(fmt::format("{}: {} cannot be written to YAML; parameters must be finite numbers",
                                     impl_->key, value));
  impl_->emitter << fmt::format("{}", value);
}
void YamlWriter::Write(int value) {
  impl_->emitter << value;
}
void YamlWriter::Write(std::uint64_t value) {
  impl_->emitter << fmt::format("{}", value);
}
void YamlWriter::Write(bool value) {
  impl_->emitter << value;
}
void YamlWriter::Write(const std::string& value) {
  impl_->Emit(value);
}

void YamlWriter::WriteNull() {
  impl_->emitter << YAML::Null;
}
void YamlWriter::WriteKey(const std::string& key) {
  impl_->key = key;
  impl_->emitter << YAML::Key;
  impl_->Emit(key);
  impl_->emitter << YAML::Value;
}
void YamlWriter::BeginMap(bool empty) {
  if (empty) impl_->emitter << YAML::Flow;
  impl_->emitter << YAML::BeginMap;
}
void YamlWriter::EndMap() {
  impl_->emitter << YAML::EndMap;
}
void YamlWriter::BeginList(bool block) {
  impl_->emitter << (block ? YAML::Block : YAML::Flow) << YAML::BeginSeq;
}
void YamlWriter::EndList() {
  impl_->emitter << YAML::EndSeq;
}

void YamlWriter::FailUnnamed(long long value) const {
  throw ParameterError(
      fmt::format("{}: the value {} has no name; name it in EnumNames()", impl_->key, value));
}

}  // namespace tenon::internal
