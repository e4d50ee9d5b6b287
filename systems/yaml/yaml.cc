#include <tenon/systems/files/input_file.h>
#include <tenon/systems/framework/block/distribution.h>
#include <tenon/systems/text/text.h>
#include <tenon/systems/yaml/internal/yaml_tree.h>
#include <tenon/systems/yaml/yaml.h>

#include <fmt/format.h>

namespace tenon {

using internal::YamlTree;

namespace {

constexpr std::string_view kFormatKey = "format";

}  // namespace

void CheckUtf8(std::string_view text, const std::string& place) {
  internal::CheckUtf8(text,
                      [&](int line, int column) { return fmt::format("{}:{}:{}", place, line, column); });
}

YamlDocument YamlDocument::Load(const std::string& file_name) {
  const std::filesystem::path path(file_name);
  std::error_code ignored;
  std::ifstream file = OpenInput(path);
  if (!file.is_open())
    throw ParameterError(fmt::format(
        "cannot read '{}': {}; check the path: {}", internal::Excerpt(file_name),
        std::filesystem::exists(path, ignored)
            ? "not a readable file (directories, pipes and devices are refused)"
            : "no such file",
        path.is_absolute()
            ? "a path in a file is relative to the directory of that file"
            : fmt::format("'{}' is relative to '{}'", file_name, std::filesystem::current_path().string())));
  std::string text;
  std::array<char, 1 << 16> part;
  while (file && text.size() <= internal::kMaxYamlBytes) {
    file.read(part.data(), part.size());
    text.append(part.data(), static_cast<std::size_t>(file.gcount()));
  }
  if (file.bad())
    throw ParameterError(fmt::format("cannot read '{}' to its end; check the disk or the network",
                                     internal::Excerpt(file_name)));
  return Parse(std::move(text), file_name);
}

YamlDocument YamlDocument::Parse(std::string text, std::string name) {
  const auto place_of = [&](int line, int column) { return fmt::format("{}:{}:{}", name, line, column); };
  const std::filesystem::path directory = std::filesystem::path(name).parent_path();
  return {std::make_shared<const YamlTree>(internal::ParseYamlTree(text, place_of, false, directory)), name};
}

void YamlDocument::CheckFormat() const {
  const auto found = YamlTree::FindKey(*tree_, kFormatKey);
  if (found == tree_->children.end()) return;
  int format = 0;
  internal::YamlNode(*found, "format").Read(internal::TypeInfoOf<int>(), &format);
  if (format < 1 || format > kYamlFormat)
    internal::FailAt(found->place,
                     fmt::format("format: {} is unknown; this version of Tenon reads formats 1 to {}{}",
                                 format, kYamlFormat, format < 1 ? "" : ", a newer one may read this file"));
}

namespace {

/// Returns the value under a dotted key and true, or its innermost existing parent and false. Keys of
/// campaigns that contain dots themselves are found, too.
std::pair<const YamlTree*, bool> Find(const YamlTree& tree, std::string_view dotted_key) {
  if (dotted_key.empty()) return {&tree, true};
  for (std::size_t end = dotted_key.size(); end != dotted_key.npos && end > 0;
       end = dotted_key.rfind('.', end - 1)) {
    const std::string_view key = dotted_key.substr(0, end);
    const std::string_view rest = dotted_key.substr(std::min(end + 1, dotted_key.size()));
    if (const auto index = internal::IndexIn(tree, key)) return Find(tree.children[*index], rest);
    const auto found = YamlTree::FindKey(tree, key);
    if (found != tree.children.end()) return Find(*found, rest);
  }
  return {&tree, false};
}

}  // namespace

void YamlDocument::Read(std::string_view dotted_key, const internal::TypeInfo& type, void* value,
                        const Scale* scale) const {
  if (std::ranges::none_of(type.fields, [](const Field& field) { return field.name == kFormatKey; }))
    CheckFormat();
  const auto [found, whole] = Find(*tree_, dotted_key);
  YamlTree empty;
  empty.kind = YamlTree::Kind::kMap;
  empty.place = found->place;
  internal::YamlNode(whole ? *found : empty, std::string(dotted_key), scale).Read(type, value);
}

std::string YamlDocument::PlaceOf(std::string_view dotted_key) const {
  return fmt::format("{}: {}", Find(*tree_, dotted_key).first->place, dotted_key);
}

std::string YamlDocument::Placed(std::string_view dotted_key, std::string_view message) const {
  const auto [found, whole] = Find(*tree_, dotted_key);
  std::string path(dotted_key);
  const YamlTree& blamed = whole ? internal::BlamedBy(*found, &path, &message) : *found;
  if (path.empty()) return fmt::format("{}: {}", name_, message);
  return fmt::format("{}: {}: {}", internal::PlaceIn(*found, blamed), path,
                     internal::WithOrigins(message, *found, blamed));
}

void YamlDocument::RefuseRenamed(const std::vector<RenamedKey>& renamed) const {
  for (const auto& [key, successor] : renamed)
    if (const auto [tree, found] = Find(*tree_, key); found)
      internal::FailAt(tree->key_place, fmt::format("{} was renamed to {}; use the new key", key, successor));
}

std::string YamlDocument::Path(std::string_view key) const {
  const auto found = YamlTree::FindKey(*tree_, key);
  return found == tree_->children.end() ? "" : internal::PathOf(*found);
}

namespace {

/// Calls enter(value, dotted key) for a value and, wherever that returns true, for the values inside it.
void ForEachValue(auto& tree, const std::string& key, const auto& enter) {
  if (!enter(tree, key)) return;
  for (std::size_t i = 0; i < tree.children.size(); ++i) {
    const std::string name = tree.kind == YamlTree::Kind::kList ? std::to_string(i) : tree.children[i].key;
    ForEachValue(tree.children[i], key.empty() ? name : key + "." + name, enter);
  }
}

}  // namespace

std::vector<std::pair<std::string, std::string>> YamlDocument::Paths() const {
  std::vector<std::pair<std::string, std::string>> paths;
  ForEachValue(*tree_, "", [&](const YamlTree& value, const std::string& key) {
    if (internal::IsPath(value)) paths.emplace_back(key, internal::PathOf(value));
    return true;
  });
  return paths;
}

std::string YamlDocument::Value(std::string_view dotted_key) const {
  const auto [tree, found] = Find(*tree_, dotted_key);
  return found ? internal::FlowText(*tree) : "";
}

std::vector<std::pair<std::string, std::string>> YamlDocument::Values() const {
  std::vector<std::pair<std::string, std::string>> values;
  ForEachValue(*tree_, "", [&](const YamlTree& value, const std::string& key) {
    const bool is_map = value.kind == YamlTree::Kind::kMap;
    if (!is_map) values.emplace_back(key, internal::FlowText(value));
    return is_map;
  });
  return values;
}

YamlDocument YamlDocument::WithAbsolutePaths() const {
  return {std::make_shared<const YamlTree>(internal::WithAbsolutePaths(*tree_, false)), name_};
}

std::string YamlDocument::Flow() const {
  return internal::FlowText(*tree_);
}

std::vector<std::string> YamlDocument::Keys(std::string_view dotted_key) const {
  std::vector<std::string> keys;
  const auto [node, found] = Find(*tree_, dotted_key);
  if (!found || node->kind != YamlTree::Kind::kMap) return keys;
  for (const YamlTree& child : node->children) keys.push_back(child.key);
  return keys;
}

std::string YamlDocument::Text(std::string_view key) const {
  const auto found = YamlTree::FindKey(*tree_, key);
  return found == tree_->children.end() ? "" : found->text;
}

namespace {

/// Adds the entry `file` to a map of changes, unless it has one.
void SayFile(YamlTree& map, YamlTree name) {
  if (YamlTree::FindKey(map, "file") != map.children.end()) return;
  name.key = "file";
  map.children.insert(map.children.begin(), std::move(name));
}

void AddMissingTo(YamlTree& tree, const YamlTree& base) {
  std::map<std::string, std::size_t> places;
  for (const YamlTree& child : tree.children) places.emplace(child.key, places.size());
  for (const YamlTree& entry : base.children) {
    const auto own = places.find(entry.key);
    if (own == places.end()) {
      tree.children.push_back(entry);
    } else if (YamlTree& child = tree.children[own->second]; child.kind == YamlTree::Kind::kMap) {
      if (entry.kind == YamlTree::Kind::kMap)
        AddMissingTo(child, entry);
      else if (internal::IsName(entry))
        SayFile(child, entry);
    }
  }
}

}  // namespace

void YamlDocument::AddMissing(const YamlDocument& base) {
  CheckFormat();
  base.CheckFormat();
  YamlTree root = *tree_;
  AddMissingTo(root, *base.tree_);
  tree_ = std::make_shared<const YamlTree>(std::move(root));
}

void YamlDocument::Change(std::string_view dotted_key, const YamlText& changes) {
  YamlTree root = internal::WithoutNulls(internal::ParseYamlTree(
      fmt::format("{{{}: {}}}", dotted_key, changes.text.empty() ? "{}" : changes.text),
      [&](int, int) { return std::string(dotted_key); }, true, {}));
  AddMissingTo(root, *tree_);
  tree_ = std::make_shared<const YamlTree>(internal::WithoutNulls(std::move(root)));
}

void YamlDocument::Remove(std::string_view key) {
  YamlTree root = *tree_;
  std::erase_if(root.children, [key](const YamlTree& entry) { return entry.key == key; });
  tree_ = std::make_shared<const YamlTree>(std::move(root));
}

void YamlDocument::Set(std::string_view dotted_key, std::string_view value_text) {
  const std::string place =
      fmt::format("--set {}={}", internal::Excerpt(dotted_key), internal::Excerpt(value_text));
  YamlTree root = *tree_;
  YamlTree* node = &root;
  for (std::size_t begin = 0; begin <= dotted_key.size();) {
    const std::size_t end = std::min(dotted_key.find('.', begin), dotted_key.size());
    const std::string_view key = dotted_key.substr(begin, end - begin);
    const std::string_view parent = dotted_key.substr(0, begin == 0 ? 0 : begin - 1);
    begin = end + 1;
    if (key.empty()) internal::FailAt(place, "a key is empty; write the path as in a.b or a.2");
    if (node->kind == YamlTree::Kind::kNull || internal::IsName(*node)) {  // becomes a map
      YamlTree was = *node;
      node->kind = YamlTree::Kind::kMap;
      if (node != &root) node->place = place;
      if (internal::IsName(was)) SayFile(*node, std::move(was));
    }
    if (node->kind == YamlTree::Kind::kMap) {
      auto it = YamlTree::FindKey(*node, key);
      if (it == node->children.end()) {
        YamlTree added;
        added.place = added.key_place = place;
        added.overridden = true;
        added.key = key;
        it = node->children.insert(it, std::move(added));
      }
      node = &*it;
    } else if (node->kind == YamlTree::Kind::kList) {
      const auto index = internal::IndexIn(*node, key);
      if (!index)
        internal::FailAt(
            place, fmt::format("'{}' is {} and has no index '{}'; indices start at 0",
                               internal::Excerpt(parent), internal::Describe(*node), internal::Excerpt(key)));
      node = &node->children[*index];
    } else {
      internal::FailAt(place, fmt::format("'{0}' is {1} and has no keys; set '{0}' itself",
                                          internal::Excerpt(parent), internal::Describe(*node)));
    }
  }
  const auto place_of = [&](int, int) { return place; };
  YamlTree value = internal::ParseYamlTree(std::string(value_text), place_of, true, {});
  if (value.kind == YamlTree::Kind::kMap) {  // changes to the same file
    const auto file = YamlTree::FindKey(*node, "file");
    if (file != node->children.end() || internal::IsName(*node))
      SayFile(value, file != node->children.end() ? *file : *node);
  }
  value.key = std::move(node->key);
  value.key_place = std::move(node->key_place);
  *node = std::move(value);
  tree_ = std::make_shared<const YamlTree>(std::move(root));
}

namespace {

/// Parses a distribution such as {uniform: [0, 1]}; empty if `tree` is none.
std::optional<Distribution> DistributionOf(const YamlTree& tree) {
  if (tree.kind != YamlTree::Kind::kMap || tree.children.size() != 1) return {};
  const YamlTree& entry = tree.children[0];
  if (!Distribution::Named(entry.key, {})) return {};
  std::array<double, 2> parameters{};
  internal::YamlNode(entry, entry.key).Read(internal::TypeInfoOf<std::array<double, 2>>(), &parameters);
  const auto distribution = Distribution::Named(entry.key, parameters);
  try {
    distribution->Validate();
  } catch (const ParameterError& error) {
    internal::FailAt(entry.place, error.what());
  }
  return distribution;
}

}  // namespace

std::vector<std::pair<std::string, double>> YamlDocument::Draw(std::uint64_t seed) {
  std::vector<std::pair<std::string, double>> drawn;
  YamlTree root = *tree_;
  ForEachValue(root, "", [&](YamlTree& value, const std::string& key) {
    const auto distribution = DistributionOf(value);
    if (!distribution) return true;
    RandomStream random(seed, key);
    drawn.emplace_back(key, distribution->Draw(random));
    value.kind = YamlTree::Kind::kScalar;
    value.text = fmt::format("{}", drawn.back().second);
    value.children.clear();
    return false;
  });
  if (!drawn.empty()) tree_ = std::make_shared<const YamlTree>(std::move(root));
  return drawn;
}

}  // namespace tenon
