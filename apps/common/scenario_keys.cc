#include <tenon/apps/common/scenario_keys.h>
#include <tenon/systems/framework/block/rate.h>
#include <tenon/systems/framework/types/diagonal_gains.h>
#include <tenon/systems/text/text.h>
#include <tenon/systems/yaml/resources.h>

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace tenon::apps {

namespace {

using internal::TypeInfo;
using Kind = TypeInfo::Kind;

/// Formats a value as in a scenario, but texts without quotes and maps without their contents.
std::string Shown(const TypeInfo& type, const void* value) {
  std::size_t count = 0, one = 0;
  switch (type.kind) {
    case Kind::kNumber:
      for (const internal::NamedValue& named : type.names)
        if (named.value == LoadInteger(type.scalar, value)) return named.name;
      break;
    case Kind::kText:
      return *static_cast<const std::string*>(value);
    case Kind::kOptional:
      type.shape(value, &count, &one);
      return count > 0 ? Shown(type.item(), type.data(const_cast<void*>(value))) : "none";
    case Kind::kMap:
      return "{}";
    case Kind::kStruct:
      return "";
    case Kind::kOpaque:
      if (*type.id == typeid(YamlFile)) return static_cast<const YamlFile*>(value)->text;
      if (*type.id != typeid(Rate)) return "";
      break;
    default:
      break;
  }
  std::string text = internal::WriteYaml(type, value);
  text.pop_back();  // the end of the line
  return text;
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
      return (*type.id == typeid(DiagonalGains) ? "number, or list: " : "list: ") + TypeText(type.item());
    case Kind::kOptional:
      return TypeText(type.item());
    case Kind::kMap:
      return "map of names: " + TypeText(type.item());
    case Kind::kStruct:
      return "map";
    case Kind::kOpaque:
      if (type.item != nullptr) return "map";
      return *type.id == typeid(Rate) ? "number" : *type.id == typeid(YamlFile) ? "file" : "anything";
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

/// The meaning of a key of a struct; empty if there is none.
std::string MeaningOf(const Meanings& meanings, const std::type_info& type, const char* key) {
  const auto own = meanings.find(StructName(type));
  if (own == meanings.end()) return "";
  const auto meaning = own->second.find(key);
  return meaning == own->second.end() ? "" : meaning->second;
}

/// Lists the keys of a struct, `scaled` as of Field::Scaled. `value` is null for items of an empty list,
/// which have their defaults.
void List(const TypeInfo& type, const void* value, bool scaled, const std::string& prefix,
          const Meanings& meanings, std::vector<ScenarioKey>& keys) {
  std::unique_ptr<internal::AnyValue> made;
  if (value == nullptr && type.construct != nullptr)
    value = (made = std::make_unique<internal::AnyValue>(type, std::byte{}))->get();
  for (const Field& field : type.fields) {
    const TypeInfo& member = field.type();
    const void* at = static_cast<const std::byte*>(value) + field.offset;
    const char* const name = scaled && field.scaled != nullptr ? field.scaled_name : field.name;
    keys.push_back({.key = prefix + name,
                    .type = field.uniform ? "number, or " + TypeText(member) : TypeText(member),
                    .unit = internal::UnitOfKey(name),
                    .range = field.range.Text(),
                    .initial = field.required ? "required" : Shown(member, at),
                    .meaning = MeaningOf(meanings, *field.owner, field.name)});
    const TypeInfo* inner = &member;
    std::string path = prefix + name;
    bool inner_scaled = scaled;
    while (inner->kind == Kind::kList || inner->kind == Kind::kArray || inner->kind == Kind::kOptional ||
           inner->kind == Kind::kMap || (inner->kind == Kind::kOpaque && inner->item != nullptr)) {
      path += inner->kind == Kind::kList || inner->kind == Kind::kArray ? "[]"
              : inner->kind == Kind::kMap                               ? ".NAME"
                                                                        : "";
      inner_scaled |= inner->kind == Kind::kOpaque && inner->count > 0;
      at = nullptr;
      inner = &inner->item();
    }
    if (inner->kind != Kind::kStruct) continue;
    if (keys.back().meaning.empty()) keys.back().meaning = MeaningOf(meanings, *inner->id, "about");
    List(*inner, at, inner_scaled, path + ".", meanings, keys);
  }
}

}  // namespace

std::string StructName(const std::type_info& type) {
  std::string name = internal::Demangled(type.name());
  name = name.substr(0, name.find('<'));
  return name.substr(name.rfind(':') + 1);
}

std::vector<ScenarioKey> KeysOf(const internal::TypeInfo& type, const void* value) {
  std::vector<ScenarioKey> keys;
  List(type, value, false, "", ReadMeanings(), keys);
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

static constexpr double kFastest = 1e5;  // Hz

Range Rates() {
  return Range().Above(0).AtMost(kFastest).Also([](double hz) { Hz(hz); });
}

Range SamplePeriods() {
  return Range().AtLeast(1 / kFastest).Also([](double s) { Seconds(s); });
}

Range Places() {
  return Range().Between(-1000, 1000);
}

}  // namespace tenon::apps
