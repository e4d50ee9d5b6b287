#include <tenon/systems/framework/block/rate.h>
#include <tenon/systems/framework/types/diagonal_gains.h>
#include <tenon/systems/text/text.h>
#include <tenon/systems/yaml/internal/yaml_tree.h>
#include <tenon/systems/yaml/yaml.h>

#include <fmt/format.h>

#include <cctype>
#include <numeric>

namespace tenon::internal {
namespace {

using Kind = YamlTree::Kind;

bool IsIndex(std::string_view key) {
  return !key.empty() && std::ranges::all_of(key, [](unsigned char c) { return std::isdigit(c) != 0; });
}

/// Suggests a valid key or a correction for an unknown key.
std::string SuggestKey(std::string_view unknown, const FieldList& keys) {
  if (keys.empty()) return "no keys are valid here; remove it";
  if (IsIndex(unknown)) return "this is a map, whose keys are names, and not a list";
  const auto [stem, unit] = SplitUnit(unknown);
  for (const Field& key : keys) {
    const auto [valid_stem, valid_unit] = SplitUnit(key.name);
    if (stem != valid_stem) continue;
    if (valid_unit.empty()) return fmt::format("'{}' takes no unit", key.name);
    if (unit.empty())
      return fmt::format("the unit is missing: give the value in {} as '{}'", valid_unit, key.name);
    return fmt::format("the unit is wrong: convert the value from {} to {} and write '{}'", unit, valid_unit,
                       key.name);
  }
  std::vector<std::string> names;
  for (const Field& key : keys) names.emplace_back(key.name);
  return fmt::format("the nearest valid key is '{}'", NearestName(unknown, names));
}

std::string JoinKeys(const FieldList& keys) {
  std::string text;
  for (const Field& key : keys) text += (text.empty() ? "" : ", ") + std::string(key.name);
  return text;
}

/// Parses a plain scalar as a number. YAML allows a leading '+'.
template <class Number>
std::errc ParseScalar(const YamlTree& tree, Number& value) {
  if (tree.kind != Kind::kScalar || tree.quoted) return std::errc::invalid_argument;
  return ParseNumber(WithoutPlus(tree.text), value);
}

bool IsNotFiniteInYaml(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text == ".nan" || text == ".inf" || text == "-.inf" || text == "+.inf";
}

}  // namespace

void YamlNode::Fail(std::string_view what) const {
  FailAt(tree_->place, path_.empty() ? std::string(what) : fmt::format("{}: {}", path_, what));
}

void YamlNode::FailValidation(std::string_view what) const {
  std::string path = path_;
  const YamlTree& blamed = BlamedBy(*tree_, &path, &what);
  FailAt(PlaceIn(*tree_, blamed),
         fmt::format("{}{}{}", path, path.empty() ? "" : ": ", WithOrigins(what, *tree_, blamed)));
}

void YamlNode::Read(const TypeInfo& type, void* value) const {
  switch (type.kind) {
    case TypeInfo::Kind::kNumber:
      return ReadNumber(type, value);
    case TypeInfo::Kind::kText:
      return ReadText(static_cast<std::string*>(value));
    case TypeInfo::Kind::kMatrix:
      return ReadMatrix(type, value);
    case TypeInfo::Kind::kStruct:
      return ReadStruct(type, value);
    case TypeInfo::Kind::kArray:
      return ReadItems(type.item(), value, Items(type.count));
    case TypeInfo::Kind::kList: {
      if (*type.id == typeid(DiagonalGains) && !IsList()) {
        type.resize(value, 1, 1);
        return ReadDouble(static_cast<double*>(type.data(value)));
      }
      const std::vector<YamlNode> items = Items();
      type.resize(value, 0, 1);  // so that items start from their defaults
      type.resize(value, items.size(), 1);
      return ReadItems(type.item(), type.data(value), items);
    }
    case TypeInfo::Kind::kOptional:
      type.resize(value, 0, 1);
      if (IsNull()) return;
      type.resize(value, 1, 1);
      return Read(type.item(), type.data(value));
    case TypeInfo::Kind::kMap:
      return ReadMap(type, value);
    case TypeInfo::Kind::kOpaque:
      if (*type.id == typeid(YamlText)) {
        static_cast<YamlText*>(value)->text = FlowText(WithAbsolutePaths(*tree_, false));
        return;
      }
      if (*type.id == typeid(YamlFile)) return ReadFile(static_cast<YamlFile*>(value));
      if (*type.id == typeid(Rate)) return ReadRate(static_cast<Rate*>(value));
      if (type.item != nullptr) return ReadChanges(type, static_cast<YamlText*>(value));
      Fail("its type has no YAML form: a struct needs a static Fields(), an enum EnumNames()");
  }
}

void YamlNode::ReadNumber(const TypeInfo& type, void* value) const {
  if (!type.names.empty()) return ReadEnumerator(type, value);
  WithKind(type.scalar, value, [this]<class Number>(Number* number) {
    if constexpr (std::is_same_v<Number, double>) {
      ReadDouble(number);
    } else if constexpr (std::is_same_v<Number, bool>) {
      ReadBool(number);
    } else if constexpr (std::is_integral_v<Number> && sizeof(Number) >= sizeof(int)) {
      ReadInteger(number);
    } else {
      Fail("its type has no YAML form: use double, int, bool, or an enum with EnumNames()");
    }
  });
}

void YamlNode::ReadDouble(double* value) const {
  const std::errc error = ParseScalar(*tree_, *value);
  if (error == std::errc::result_out_of_range)
    Fail(
        fmt::format("{} is outside the range of a double; use exponents from -307 to 308", Describe(*tree_)));
  if (tree_->kind == Kind::kScalar && !tree_->quoted &&
      (IsNotFiniteInYaml(tree_->text) || (error == std::errc() && !std::isfinite(*value))))
    Fail(fmt::format("expected a finite number, found {}; infinities and NaN are not allowed",
                     Describe(*tree_)));
  if (error != std::errc())
    Fail(fmt::format("expected a number, found {}; write only a number, such as 0.5 or 2e-3",
                     Describe(*tree_)));
}

template <class Integer>
void YamlNode::ReadInteger(Integer* value) const {
  using Limits = std::numeric_limits<Integer>;
  std::string_view digits = tree_->text;
  if (digits.starts_with('-') || digits.starts_with('+')) digits.remove_prefix(1);
  const bool all_digits = digits.find_first_not_of("0123456789") == digits.npos;
  if (tree_->kind == Kind::kScalar && all_digits && digits.size() > 1 && digits.front() == '0')
    Fail(fmt::format("{} begins with a 0, which some YAML readers take for an octal number; remove the 0",
                     Describe(*tree_)));
  if (ParseScalar(*tree_, *value) == std::errc()) return;
  Fail(fmt::format("expected an integer from {} to {}, found {}; write only digits", Limits::min(),
                   Limits::max(), Describe(*tree_)));
}

void YamlNode::ReadBool(bool* value) const {
  const bool is_plain = tree_->kind == Kind::kScalar && !tree_->quoted;
  if (!is_plain || (tree_->text != "true" && tree_->text != "false"))
    Fail(fmt::format("expected true or false, found {}; write one of these words", Describe(*tree_)));
  *value = tree_->text == "true";
}

void YamlNode::ReadEnumerator(const TypeInfo& type, void* value) const {
  std::string names;
  for (const NamedValue& named : type.names) {
    if (tree_->kind == Kind::kScalar && tree_->text == named.name)
      return StoreInteger(type.scalar, value, named.value);
    names += (names.empty() ? "" : ", ") + std::string(named.name);
  }
  Fail(fmt::format("expected one of {}; found {}", names, Describe(*tree_)));
}

void YamlNode::ReadText(std::string* value) const {
  if (tree_->kind != Kind::kScalar)
    Fail(fmt::format("expected text, found {}; write one word, or quote the text", Describe(*tree_)));
  *value = tree_->text;
}

/// Reads a vector from a list, and a matrix from a list of rows or the list of its diagonal.
void YamlNode::ReadMatrix(const TypeInfo& type, void* value) const {
  if (type.rows < 1 || type.cols < 1 || type.scalar != ScalarKind::kDouble)
    Fail("its type has no YAML form: only vectors and matrices of doubles and of fixed size have one");
  const auto rows = static_cast<std::size_t>(type.rows), cols = static_cast<std::size_t>(type.cols);
  auto* numbers = static_cast<double*>(type.data(value));
  const std::vector<YamlNode> items = Items(rows);
  const bool diagonal = rows == cols && !items[0].IsList();
  std::fill(numbers, numbers + rows * cols, 0.0);
  for (std::size_t r = 0; r < rows; ++r) {
    if (cols == 1 || diagonal) {
      items[r].ReadDouble(numbers + r + (cols == 1 ? 0 : r * rows));
    } else {
      const std::vector<YamlNode> row = items[r].Items(cols);
      for (std::size_t c = 0; c < cols; ++c) row[c].ReadDouble(numbers + c * rows + r);
    }
  }
}

namespace {

/// The numbers of a field that Field::Scaled converts.
std::span<double> ScaledNumbers(const Field& field, void* value) {
  const TypeInfo& type = field.type();
  if (type.kind == TypeInfo::Kind::kList)
    return {static_cast<double*>(type.data(value)), ExtentsOf(type, value).rows};
  return {static_cast<double*>(value), static_cast<std::size_t>(std::max(1, type.rows))};
}

}  // namespace

const char* YamlNode::KeyOf(const Field& field) const {
  return scale_ != nullptr && field.scaled != nullptr ? field.scaled_name : field.name;
}

void YamlNode::ReadField(const Field& field, void* value) const {
  if (field.uniform && !IsList()) {
    double number = 0;
    ReadDouble(&number);
    auto* const numbers = static_cast<double*>(field.type().data(value));
    std::fill(numbers, numbers + field.type().rows, number);
  } else {
    Read(field.type(), value);
  }
}

void YamlNode::ReadStruct(const TypeInfo& type, void* value) const {
  CheckKeys(type.fields, value);
  const auto at = [&](const Field& field) { return static_cast<std::byte*>(value) + field.offset; };
  for (const Field& field : type.fields)
    if (const auto node = Find(KeyOf(field))) node->ReadField(field, at(field));
  try {
    for (const Field& field : type.fields) {
      if (!field.range.any()) CheckRange({KeyOf(field), field.units, &field.range, &field.type()}, at(field));
      if (scale_ == nullptr || field.scaled == nullptr || !Find(KeyOf(field))) continue;
      for (double& number : ScaledNumbers(field, at(field))) number = field.scaled(number, *scale_);
    }
    if (type.validate != nullptr && !is_part_) type.validate(value);
  } catch (const ParameterError& error) {
    FailValidation(error.what());
  }
}

void YamlNode::ReadRate(Rate* value) const {
  if (IsNull()) return;
  double hz = 0;
  ReadDouble(&hz);
  static const Range kRates =
      Range().Above(0).AtMost(Field::kFastestRate).Also([](double rate) { Hz(rate); });
  if (!kRates.Contains(hz)) {
    try {
      kRates.Refuse(hz, path_.substr(path_.rfind('.') + 1), "Hz");
    } catch (const ParameterError& error) {
      Fail(error.what());
    }
  }
  *value = Hz(hz);
}

void YamlNode::ReadChanges(const TypeInfo& type, YamlText* value) const {
  const AnyValue changed(type.item(), std::byte{});
  static const Scale kAny;
  const YamlTree given = WithoutNulls(*tree_);
  YamlNode(given, path_, type.count > 0 ? &kAny : nullptr, true).Read(type.item(), changed.get());
  value->text = FlowText(WithAbsolutePaths(given, false));
}

void YamlNode::ReadItems(const TypeInfo& item, void* first, const std::vector<YamlNode>& items) const {
  auto* at = static_cast<std::byte*>(first);
  for (const YamlNode& node : items) {
    node.Read(item, at);
    at += item.size;
  }
}

void YamlNode::ReadFile(YamlFile* value) const {
  YamlTree tree = WithAbsolutePaths(*tree_, true);
  if (tree.kind == Kind::kMap && YamlTree::FindKey(tree, "file") == tree.children.end()) {
    if (value->text.empty() || value->text.front() == '{')
      Fail("a map of changes needs the key `file`, as in {file: standard, …}");
    YamlTree file;
    file.kind = Kind::kScalar;
    file.key = "file";
    file.text = value->text;
    tree.children.insert(tree.children.begin(), std::move(file));
  }
  if (tree.kind != Kind::kMap && (tree.kind != Kind::kScalar || tree.text.empty()))
    Fail(fmt::format("expected a name, a path, or a map such as {{file: standard, …}}; found {}",
                     Describe(*tree_)));
  value->text = FlowText(tree);
}

void YamlNode::ReadMap(const TypeInfo& type, void* value) const {
  if (tree_->kind != Kind::kMap)
    Fail(fmt::format("expected a map of keys and values, found {}; write 'key: value' lines",
                     Describe(*tree_)));
  type.clear(value);
  for (const YamlTree& child : tree_->children) {
    Child(child, child.key).Read(type.item(), type.insert(value, child.key));
  }
}

std::string YamlNode::Below(std::string_view key) const {
  return path_.empty() ? Excerpt(key) : fmt::format("{}.{}", path_, Excerpt(key));
}

YamlNode YamlNode::Child(const YamlTree& child, std::string_view key) const {
  return {child, Below(key), scale_, is_part_};
}

std::vector<YamlNode> YamlNode::Items() const {
  if (tree_->kind == Kind::kMap && !tree_->children.empty() && IsIndex(tree_->children.front().key))
    Fail(
        fmt::format("the list is in another file, so its element {} cannot be set alone: give the whole list "
                    "in brackets, or a "
                    "copy of that file",
                    tree_->children.front().key));
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

std::optional<YamlNode> YamlNode::Find(std::string_view key) const {
  const auto it = YamlTree::FindKey(*tree_, key);
  if (it == tree_->children.end()) return std::nullopt;
  return Child(*it, key);
}

bool YamlNode::NeedsScale(const Field& field, const void* value) {
  const auto* const at = static_cast<const std::byte*>(value) + field.offset;
  if (field.scaled != nullptr) return ScaledNumbers(field, const_cast<std::byte*>(at))[0] != 0;
  return field.type().kind == TypeInfo::Kind::kStruct &&
         std::ranges::any_of(field.type().fields, [at](const Field& part) { return NeedsScale(part, at); });
}

void YamlNode::CheckKeys(FieldList keys, const void* value) const {
  for (Field& key : keys) {
    key.required |= scale_ != nullptr && NeedsScale(key, value);
    key.name = KeyOf(key);
  }
  const bool empty_document = path_.empty() && IsNull();
  if (tree_->kind != Kind::kMap && !empty_document)
    Fail(fmt::format("expected a map, found {}; valid keys: {}", Describe(*tree_), JoinKeys(keys)));
  for (const YamlTree& child : tree_->children) {
    if (std::ranges::find(keys, child.key, [](const Field& key) { return std::string_view(key.name); }) !=
        keys.end())
      continue;
    if (path_.empty() && child.key == "format") continue;  // checked by YamlDocument::CheckFormat
    FailAt(child.key_place, fmt::format("{}: unknown key; {}. Valid keys: {}", Below(child.key),
                                        SuggestKey(child.key, keys), JoinKeys(keys)));
  }
  FieldList missing;
  for (const Field& key : keys)
    if (key.required && !is_part_ && !Find(key.name)) missing.push_back(key);
  if (!missing.empty())
    Fail(fmt::format("required but missing: {}; add {}, because there is no default", JoinKeys(missing),
                     missing.size() == 1 ? "it" : "them"));
}

}  // namespace tenon::internal
