#include <tenon/systems/yaml/yaml_node.h>

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <limits>
#include <numeric>
#include <system_error>

#include <tenon/systems/framework/internal/nearest_name.h>
#include <tenon/systems/yaml/yaml_tree.h>

namespace tenon::internal {
namespace {

using Kind = YamlTree::Kind;

bool IsUnit(std::string_view word) {
  constexpr std::string_view kUnits[] = {
      "m", "mm", "cm",  "km",  "um",  "g",    "kg",  "t",   "lb",  "s",   "ms",      "us", "ns",
      "h", "Hz", "kHz", "rpm", "rad", "mrad", "deg", "N",   "mN",  "kN",  "Nm",      "J",  "kJ",
      "W", "kW", "V",   "mV",  "A",   "mA",   "Pa",  "kPa", "MPa", "GPa", "percent", "per"};
  while (word.size() > 1 && word.back() >= '2' && word.back() <= '4') word.remove_suffix(1);
  return std::ranges::count(kUnits, word) > 0;
}

/// `inertia_kg_m2` is "inertia" in "kg_m2".
std::pair<std::string_view, std::string_view> SplitUnit(std::string_view key) {
  std::size_t end = key.size();
  while (true) {
    const std::size_t bar = key.substr(0, end).rfind('_');
    if (bar == std::string_view::npos || bar == 0 || !IsUnit(key.substr(bar + 1, end - bar - 1))) break;
    end = bar;
  }
  return {key.substr(0, end), end == key.size() ? "" : key.substr(end + 1)};
}

/// What the writer of an unknown key should have written.
std::string SuggestKey(std::string_view unknown, std::span<const YamlKey> keys) {
  if (keys.empty()) return "no keys are valid here; remove it";
  const auto [stem, unit] = SplitUnit(unknown);
  for (const YamlKey& key : keys) {
    const auto [valid_stem, valid_unit] = SplitUnit(key.name);
    if (stem != valid_stem) continue;
    if (valid_unit.empty()) return fmt::format("'{}' takes no unit", key.name);
    if (unit.empty())
      return fmt::format("the unit is missing: give the value in {} as '{}'", valid_unit, key.name);
    return fmt::format("the unit is wrong: convert the value from {} to {} and write '{}'", unit, valid_unit,
                       key.name);
  }
  std::vector<std::string> names;
  for (const YamlKey& key : keys) names.emplace_back(key.name);
  return fmt::format("the nearest valid key is '{}'", NearestName(unknown, names));
}

std::string JoinKeys(std::span<const YamlKey> keys) {
  std::string text;
  for (const YamlKey& key : keys) text += (text.empty() ? "" : ", ") + std::string(key.name);
  return text;
}

void ListOverrides(const YamlTree& tree, std::vector<std::string>& places) {
  if (tree.overridden && std::ranges::count(places, tree.place) == 0) places.push_back(tree.place);
  for (const YamlTree& child : tree.children) ListOverrides(child, places);
}

/// The whole of a plain scalar as a number. A leading '+' is YAML, though not C++.
template <class Number>
std::errc ParseNumber(const YamlTree& tree, Number& value) {
  if (tree.kind != Kind::kScalar || tree.quoted) return std::errc::invalid_argument;
  std::string_view text = tree.text;
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return end == text.data() + text.size() ? error : std::errc::invalid_argument;
}

bool IsNotFiniteInYaml(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text == ".nan" || text == ".inf" || text == "-.inf" || text == "+.inf";
}

template <class Integer>
Integer ParseInteger(const YamlTree& tree, const std::function<void(const std::string&)>& fail) {
  Integer value = 0;
  using Limits = std::numeric_limits<Integer>;
  if (const std::errc error = ParseNumber(tree, value); error != std::errc())
    fail(fmt::format("expected an integer from {} to {}, found {}; write digits alone", Limits::min(),
                     Limits::max(), Describe(tree)));
  return value;
}

}  // namespace

void YamlNode::Fail(std::string_view what) const {
  FailAt(tree_->place, path_.empty() ? std::string(what) : fmt::format("{}: {}", path_, what));
}

void YamlNode::FailValidation(std::string_view what) const {
  std::vector<std::string> overrides;
  if (!tree_->overridden) ListOverrides(*tree_, overrides);
  std::string text(what);
  for (const std::string& place : overrides) text += fmt::format(" (with {})", place);
  Fail(text);
}

void YamlNode::Read(double& value) const {
  const std::errc error = ParseNumber(*tree_, value);
  if (error == std::errc::result_out_of_range)
    Fail(fmt::format("{} is outside the range of a double; write a smaller power of ten", Describe(*tree_)));
  if (tree_->kind == Kind::kScalar && !tree_->quoted &&
      (IsNotFiniteInYaml(tree_->text) || (error == std::errc() && !std::isfinite(value))))
    Fail(fmt::format("expected a finite number, found {}; infinities and NaN are refused", Describe(*tree_)));
  if (error != std::errc())
    Fail(fmt::format("expected a number, found {}; write a number alone, such as 0.5 or 2e-3",
                     Describe(*tree_)));
}

void YamlNode::Read(int& value) const {
  value = ParseInteger<int>(*tree_, [this](const std::string& what) { Fail(what); });
}

void YamlNode::Read(std::uint64_t& value) const {
  value = ParseInteger<std::uint64_t>(*tree_, [this](const std::string& what) { Fail(what); });
}

void YamlNode::Read(bool& value) const {
  const bool is_plain = tree_->kind == Kind::kScalar && !tree_->quoted;
  if (!is_plain || (tree_->text != "true" && tree_->text != "false"))
    Fail(fmt::format("expected true or false, found {}; write one of these words", Describe(*tree_)));
  value = tree_->text == "true";
}

void YamlNode::Read(std::string& value) const {
  if (tree_->kind != Kind::kScalar)
    Fail(fmt::format("expected text, found {}; write one word, or quote the text", Describe(*tree_)));
  value = tree_->text;
}

std::size_t YamlNode::IndexIn(std::span<const std::string_view> names) const {
  const auto it = std::ranges::find(names, tree_->text);
  if (tree_->kind != Kind::kScalar || it == names.end())
    Fail(fmt::format("expected one of {}; found {}", fmt::join(names, ", "), Describe(*tree_)));
  return static_cast<std::size_t>(it - names.begin());
}

bool YamlNode::IsNull() const {
  return tree_->kind == Kind::kNull;
}
bool YamlNode::IsList() const {
  return tree_->kind == Kind::kList;
}

YamlNode YamlNode::Child(const YamlTree& child, std::string_view key) const {
  return {child, path_.empty() ? std::string(key) : fmt::format("{}.{}", path_, key)};
}

std::vector<YamlNode> YamlNode::Items() const {
  if (!IsList())
    Fail(fmt::format("expected a list, found {}; write it in brackets, as in [1, 2]", Describe(*tree_)));
  std::vector<YamlNode> items;
  for (const YamlTree& child : tree_->children) items.push_back(Child(child, std::to_string(items.size())));
  return items;
}

std::vector<YamlNode> YamlNode::Items(std::size_t count) const {
  if (!IsList() || tree_->children.size() != count)
    Fail(fmt::format("expected a list of {}, found {}; write {} values in brackets", count, Describe(*tree_),
                     count));
  return Items();
}

std::vector<std::pair<std::string, YamlNode>> YamlNode::Entries() const {
  if (tree_->kind != Kind::kMap)
    Fail(fmt::format("expected a map of keys and values, found {}; write 'key: value' lines",
                     Describe(*tree_)));
  std::vector<std::pair<std::string, YamlNode>> entries;
  for (const YamlTree& child : tree_->children) entries.emplace_back(child.key, Child(child, child.key));
  return entries;
}

std::optional<YamlNode> YamlNode::Find(std::string_view key) const {
  const auto it = YamlTree::FindKey(*tree_, key);
  if (it == tree_->children.end()) return std::nullopt;
  return Child(*it, key);
}

void YamlNode::CheckKeys(std::span<const YamlKey> keys) const {
  const bool empty_document = path_.empty() && IsNull();
  if (tree_->kind != Kind::kMap && !empty_document)
    Fail(fmt::format("expected a map, found {}; valid keys: {}", Describe(*tree_), JoinKeys(keys)));
  for (const YamlTree& child : tree_->children) {
    if (std::ranges::find(keys, child.key, [](const YamlKey& key) { return std::string_view(key.name); }) !=
        keys.end())
      continue;
    const std::string path = path_.empty() ? child.key : fmt::format("{}.{}", path_, child.key);
    FailAt(child.key_place, fmt::format("{}: unknown key; {}. Valid keys: {}", path,
                                        SuggestKey(child.key, keys), JoinKeys(keys)));
  }
  std::vector<YamlKey> missing;
  for (const YamlKey& key : keys)
    if (key.required && !Find(key.name)) missing.push_back(key);
  if (!missing.empty())
    Fail(fmt::format("required but missing: {}; add {}, there is no default", JoinKeys(missing),
                     missing.size() == 1 ? "it" : "them"));
}

}  // namespace tenon::internal
