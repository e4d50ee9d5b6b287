#include <tenon/systems/yaml/yaml.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <system_error>

#include <tenon/systems/framework/errors.h>
#include <tenon/systems/framework/internal/excerpt.h>
#include <tenon/systems/yaml/internal/yaml_node.h>
#include <tenon/systems/yaml/internal/yaml_writer.h>

namespace tenon {

using internal::YamlTree;

void CheckUtf8(std::string_view text, const std::string& place) {
  internal::CheckUtf8(text,
                      [&](int line, int column) { return fmt::format("{}:{}:{}", place, line, column); });
}

YamlDocument YamlDocument::Load(const std::string& file_name) {
  const std::filesystem::path path(file_name);
  std::error_code ignored;
  std::ifstream file(path);
  if (!file || std::filesystem::is_directory(path, ignored))
    throw ParameterError(
        fmt::format("cannot read '{}': {}; check the path, which starts from '{}' unless it is absolute",
                    internal::Excerpt(file_name),
                    std::filesystem::exists(path, ignored) ? "not a readable file" : "no such file",
                    std::filesystem::current_path().string()));
  std::string text;
  std::array<char, 1 << 16> part;
  while (file && text.size() <= internal::kMaxYamlBytes) {  // a device may have no end
    file.read(part.data(), part.size());
    text.append(part.data(), static_cast<std::size_t>(file.gcount()));
  }
  if (file.bad())
    throw ParameterError(fmt::format("cannot read '{}' to its end: is the disk or the network broken?",
                                     internal::Excerpt(file_name)));
  return Parse(std::move(text), file_name);
}

YamlDocument YamlDocument::Parse(std::string text, std::string name) {
  const auto place_of = [&](int line, int column) { return fmt::format("{}:{}:{}", name, line, column); };
  return {std::make_shared<const YamlTree>(internal::ParseYamlTree(text, place_of, false)), name};
}

void YamlDocument::Read(const internal::TypeInfo& type, void* value) const {
  internal::YamlNode(*tree_, "").Read(type, value);
}

namespace {

/// The index that a key is in a list; none if it is no number, or too large.
std::optional<std::size_t> IndexIn(const YamlTree& list, std::string_view key) {
  std::size_t index = 0;
  const auto [end, error] = std::from_chars(key.data(), key.data() + key.size(), index);
  const bool is_index = error == std::errc() && end == key.data() + key.size();
  if (list.kind != YamlTree::Kind::kList || !is_index || index >= list.children.size()) return {};
  return index;
}

}  // namespace

std::string YamlDocument::PlaceOf(std::string_view dotted_key) const {
  const YamlTree* node = tree_.get();
  for (std::size_t begin = 0; begin < dotted_key.size();) {
    const std::size_t end = std::min(dotted_key.find('.', begin), dotted_key.size());
    const std::string_view key = dotted_key.substr(begin, end - begin);
    begin = end + 1;
    if (const auto index = IndexIn(*node, key)) {
      node = &node->children[*index];
      continue;
    }
    const auto found = YamlTree::FindKey(*node, key);
    if (found == node->children.end()) break;
    node = &*found;
  }
  return fmt::format("{}: {}", node->place, dotted_key);
}

std::string YamlDocument::Text(std::string_view key) const {
  const auto found = YamlTree::FindKey(*tree_, key);
  return found == tree_->children.end() ? "" : found->text;
}

namespace {

void AddMissingTo(YamlTree& tree, const YamlTree& base) {
  std::map<std::string, std::size_t> places;
  for (const YamlTree& child : tree.children) places.emplace(child.key, places.size());
  for (const YamlTree& entry : base.children) {
    const auto own = places.find(entry.key);
    if (own == places.end()) {
      tree.children.push_back(entry);
    } else if (YamlTree& child = tree.children[own->second];
               child.kind == YamlTree::Kind::kMap && entry.kind == YamlTree::Kind::kMap) {
      AddMissingTo(child, entry);
    }
  }
}

}  // namespace

void YamlDocument::AddMissing(const YamlDocument& base) {
  YamlTree root = *tree_;
  AddMissingTo(root, *base.tree_);
  tree_ = std::make_shared<const YamlTree>(std::move(root));
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
    if (node->kind == YamlTree::Kind::kNull) node->kind = YamlTree::Kind::kMap;
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
      const auto index = IndexIn(*node, key);
      if (!index)
        internal::FailAt(
            place, fmt::format("'{}' is {}, '{}' is no index of it; count from 0", internal::Excerpt(parent),
                               internal::Describe(*node), internal::Excerpt(key)));
      node = &node->children[*index];
    } else {
      internal::FailAt(place, fmt::format("'{0}' is {1} and has nothing inside; set '{0}' itself",
                                          internal::Excerpt(parent), internal::Describe(*node)));
    }
  }
  const auto place_of = [&](int, int) { return place; };
  YamlTree value = internal::ParseYamlTree(std::string(value_text), place_of, true);
  value.key = std::move(node->key);
  value.key_place = std::move(node->key_place);
  *node = std::move(value);
  tree_ = std::make_shared<const YamlTree>(std::move(root));
}

}  // namespace tenon
