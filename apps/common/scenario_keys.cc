#include <tenon/apps/common/scenario_keys.h>
#include <tenon/systems/text/key_unit.h>
#include <tenon/systems/yaml/resources.h>
#include <tenon/systems/yaml/yaml.h>

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <typeinfo>

namespace tenon::apps {
namespace {

using internal::TypeInfo;
using Kind = TypeInfo::Kind;

/// Formats a value as in a scenario.
std::string Shown(const TypeInfo& type, const void* value);

std::string ShownItems(const TypeInfo& item, const void* first, std::size_t count) {
  std::vector<std::string> texts;
  for (std::size_t i = 0; i < count; ++i)
    texts.push_back(Shown(item, static_cast<const std::byte*>(first) + i * item.size));
  return fmt::format("[{}]", fmt::join(texts, ", "));
}

std::string ShownMatrix(const TypeInfo& type, const void* value) {
  const auto* numbers = static_cast<const double*>(type.data(const_cast<void*>(value)));
  std::vector<std::string> rows;
  for (int r = 0; r < type.rows; ++r) {
    std::vector<double> row;
    for (int c = 0; c < type.cols; ++c) row.push_back(numbers[c * type.rows + r]);
    rows.push_back(type.cols == 1 ? fmt::format("{}", row[0]) : fmt::format("[{}]", fmt::join(row, ", ")));
  }
  return fmt::format("[{}]", fmt::join(rows, ", "));
}

std::string Shown(const TypeInfo& type, const void* value) {
  std::size_t count = 0, one = 0;
  if (type.kind == Kind::kList || type.kind == Kind::kOptional) type.shape(value, &count, &one);
  switch (type.kind) {
    case Kind::kNumber: {
      if (type.scalar == internal::ScalarKind::kDouble)
        return fmt::format("{}", *static_cast<const double*>(value));
      const long long number = LoadInteger(type.scalar, value);
      if (type.scalar == internal::ScalarKind::kBool) return number != 0 ? "true" : "false";
      for (const internal::NamedValue& named : type.names)
        if (named.value == number) return named.name;
      return fmt::format("{}", number);
    }
    case Kind::kText:
      return *static_cast<const std::string*>(value);
    case Kind::kMatrix:
      return ShownMatrix(type, value);
    case Kind::kArray:
      return ShownItems(type.item(), value, type.count);
    case Kind::kList:
      return ShownItems(type.item(), type.data(const_cast<void*>(value)), count);
    case Kind::kOptional:
      return count > 0 ? Shown(type.item(), type.data(const_cast<void*>(value))) : "none";
    case Kind::kMap:
      return "{}";
    case Kind::kOpaque:
      if (*type.id == typeid(YamlFile)) return static_cast<const YamlFile*>(value)->text;
      return "";
    case Kind::kStruct:
      return "";
  }
  return "";
}

std::string TypeText(const TypeInfo& type) {
  switch (type.kind) {
    case Kind::kNumber: {
      if (type.scalar == internal::ScalarKind::kDouble) return "number";
      if (type.scalar == internal::ScalarKind::kBool) return "true or false";
      if (type.names.empty()) return "integer";
      std::vector<std::string> names;
      for (const internal::NamedValue& named : type.names) names.emplace_back(named.name);
      return fmt::format("{}", fmt::join(names, ", "));
    }
    case Kind::kText:
      return "text";
    case Kind::kMatrix:
      return type.cols == 1 ? fmt::format("{} numbers", type.rows)
                            : fmt::format("{} rows of {} numbers", type.rows, type.cols);
    case Kind::kArray:
      return fmt::format("{} times: {}", type.count, TypeText(type.item()));
    case Kind::kList:
      return "list: " + TypeText(type.item());
    case Kind::kOptional:
      return TypeText(type.item());
    case Kind::kMap:
      return "map of names: " + TypeText(type.item());
    case Kind::kStruct:
      return "map";
    case Kind::kOpaque:
      return *type.id == typeid(YamlFile) ? "file" : "anything";
  }
  return "";
}

using Meanings = std::map<std::string, std::map<std::string, std::string>>;

struct MeaningsFile {
  Meanings structs;
  static FieldList Fields() { return {{"structs", &MeaningsFile::structs}}; }
};

/// Reads the meanings by struct and key; empty if Tenon's data is not installed.
Meanings ReadMeanings() {
  const std::filesystem::path file = DataDirectory() / "keys" / "meanings.yaml";
  if (!std::filesystem::exists(file)) return {};
  return YamlDocument::Load(file).Read<MeaningsFile>().structs;
}

/// Lists the keys of a struct. `value` is null for items of an empty list, which have their defaults.
void List(const TypeInfo& type, const void* value, const std::string& prefix, const Meanings& meanings,
          std::vector<ScenarioKey>& keys) {
  std::vector<std::byte> memory;
  void* made = nullptr;
  if (value == nullptr && type.construct != nullptr) {
    memory.resize(type.size + type.alignment);
    void* start = memory.data();
    std::size_t space = memory.size();
    made = std::align(type.alignment, type.size, start, space);
    type.construct(made);
    value = made;
  }
  auto own = meanings.find(StructName(type));
  if (own == meanings.end()) own = meanings.find("AppScenario");  // of a scenario outside Tenon
  for (const Field& field : type.fields) {
    const TypeInfo& member = field.type();
    const void* at = static_cast<const std::byte*>(value) + field.offset;
    ScenarioKey key{.key = prefix + field.name,
                    .type = TypeText(member),
                    .unit = internal::UnitOfKey(field.name),
                    .range = field.range.Text(),
                    .initial = field.required ? "required" : Shown(member, at),
                    .meaning = {}};
    if (own != meanings.end())
      if (const auto told = own->second.find(field.name); told != own->second.end())
        key.meaning = told->second;
    keys.push_back(std::move(key));
    const TypeInfo* inner = &member;
    std::string path = prefix + field.name;
    while (inner->kind == Kind::kList || inner->kind == Kind::kArray || inner->kind == Kind::kOptional ||
           inner->kind == Kind::kMap) {
      path += inner->kind == Kind::kOptional ? "" : inner->kind == Kind::kMap ? ".NAME" : "[]";
      at = nullptr;
      inner = &inner->item();
    }
    if (inner->kind == Kind::kStruct && keys.back().meaning.empty())
      if (const auto told = meanings.find(StructName(*inner)); told != meanings.end())
        if (const auto about = told->second.find("about"); about != told->second.end())
          keys.back().meaning = about->second;
    if (inner->kind == Kind::kStruct) List(*inner, at, path + ".", meanings, keys);
  }
  if (made != nullptr) type.destroy(made);
}

}  // namespace

std::string StructName(const internal::TypeInfo& type) {
  std::string name = TypeName(type);
  name = name.substr(0, name.find('<'));
  return name.substr(name.rfind(':') + 1);
}

std::vector<ScenarioKey> KeysOf(const internal::TypeInfo& type, const void* value) {
  std::vector<ScenarioKey> keys;
  List(type, value, "", ReadMeanings(), keys);
  return keys;
}

std::vector<ScenarioKey> KeysOfFile(const std::string& kind, const YamlFile& what, const std::string& key,
                                    const std::vector<ScenarioKey>& known) {
  std::vector<ScenarioKey> keys;
  if (what.text.empty() || what.text == "none") return keys;
  for (const auto& [name, text] : LoadResource(kind, what).Values()) {
    const auto same = std::ranges::find(known, name, &ScenarioKey::key);
    const bool found = same != known.end();
    keys.push_back({.key = key + "." + name,
                    .type = "in " + ResourceName(what),
                    .unit = internal::UnitOfKey(name.substr(name.rfind('.') + 1)),
                    .range = found ? same->range : "",
                    .initial = text,
                    .meaning = found ? same->meaning : ""});
  }
  return keys;
}

void PrintKeys(const std::vector<ScenarioKey>& keys) {
  for (const ScenarioKey& key : keys)
    fmt::print("{:<48} {:<14} {:<10} {:<16} {:<16} {}\n", key.key, key.type,
               key.unit.empty() ? "-" : key.unit, key.range.empty() ? "-" : key.range,
               key.initial.empty() ? "-" : key.initial, key.meaning);
}

}  // namespace tenon::apps
