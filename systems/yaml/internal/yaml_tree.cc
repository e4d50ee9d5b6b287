#include <tenon/systems/framework/types/errors.h>
#include <tenon/systems/text/text.h>
#include <tenon/systems/yaml/internal/yaml_tree.h>

#include <fmt/ranges.h>
#include <utf8.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <cctype>
#include <sstream>

namespace tenon::internal {
namespace {

using Kind = YamlTree::Kind;

/// Builds the tree from the parser's events, because YAML::Node hides duplicate keys.
class TreeBuilder final : public YAML::EventHandler {
 public:
  TreeBuilder(const YamlPlaceOf& place_of, bool overridden, const std::filesystem::path& directory)
      : place_of_(place_of),
        overridden_(overridden),
        directory_(std::make_shared<const std::filesystem::path>(directory)),
        root_(Make({}, Kind::kNull)) {}

  YamlTree Take() {
    if (!bad_key_.empty())
      FailAt(bad_key_, "a key must be a word; quote it if it contains special characters");
    return std::move(root_);
  }

  void OnDocumentStart(const YAML::Mark& mark) override {
    if (++documents_ > 1) FailAt(PlaceOf(mark), "a second document begins here; keep one per file");
  }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    Add(Make(mark, Kind::kNull), anchor);
  }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& text) override {
    YamlTree tree = Make(mark, Kind::kScalar);
    tree.text = text;
    tree.quoted = tag == "!";
    if (tag != "?") RefuseTag(mark, tag);
    Add(std::move(tree), anchor);
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    const auto it = anchors_.find(anchor);
    if (it == anchors_.end())
      FailAt(PlaceOf(mark), "the alias is inside its own anchor; repeat the value instead");
    Count(it->second, PlaceOf(mark));
    Add(it->second, 0);
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    Open(mark, tag, anchor, Kind::kList);
  }
  void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    Open(mark, tag, anchor, Kind::kMap);
  }
  void OnSequenceEnd() override { Close(); }
  void OnMapEnd() override { Close(); }

 private:
  std::string PlaceOf(const YAML::Mark& mark) const { return place_of_(mark.line + 1, mark.column + 1); }
  struct Level {
    YamlTree tree;
    YAML::anchor_t anchor;
    std::optional<YamlTree> key = {};  // key of the next value
  };

  YamlTree Make(const YAML::Mark& mark, Kind kind) {
    YamlTree tree;
    tree.kind = kind;
    tree.place = PlaceOf(mark);
    tree.overridden = overridden_;
    tree.directory = directory_;
    Count(tree, tree.place);
    return tree;
  }
  /// Counts the values of a tree. Throws if the document has too many.
  void Count(const YamlTree& tree, const std::string& place) {
    if (++values_ > kMaxYamlValues)
      FailAt(place,
             fmt::format("{}the document has more than {} keys and values, including those that aliases "
                         "and anchors repeat; shorten it",
                         OpenKeys(), kMaxYamlValues));
    for (const YamlTree& child : tree.children) Count(child, place);
  }
  /// Returns the keys whose values are being read as "a.b: ".
  std::string OpenKeys() const {
    std::vector<std::string> keys;
    for (const Level& level : open_) {
      if (level.key) keys.push_back(Excerpt(level.key->text));
    }
    return keys.empty() ? "" : fmt::format("{}: ", fmt::join(keys, "."));
  }
  void RefuseDoubles(const YamlTree& map) const {
    if (map.kind != Kind::kMap || !bad_key_.empty()) return;
    std::vector<const YamlTree*> entries;
    for (const YamlTree& entry : map.children) entries.push_back(&entry);
    std::ranges::stable_sort(entries, {}, &YamlTree::key);
    const auto twice = std::ranges::adjacent_find(entries, {}, &YamlTree::key);
    if (twice == entries.end()) return;
    FailAt(twice[1]->key_place, fmt::format("the key '{}' is given twice, first at {}; remove one of them",
                                            Excerpt(twice[0]->key), twice[0]->key_place));
  }
  void RefuseTag(const YAML::Mark& mark, const std::string& tag) const {
    if (!tag.empty() && tag != "?" && tag != "!")
      FailAt(PlaceOf(mark), fmt::format("the tag '{}' has no meaning here; remove it", Excerpt(tag)));
  }
  bool ExpectsKey() const {
    return !open_.empty() && open_.back().tree.kind == Kind::kMap && !open_.back().key;
  }
  void Open(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor, Kind kind) {
    RefuseTag(mark, tag);
    open_.push_back({Make(mark, kind), anchor});
  }
  void Close() {
    Level level = std::move(open_.back());
    open_.pop_back();
    RefuseDoubles(level.tree);
    Add(std::move(level.tree), level.anchor);
  }
  void Add(YamlTree tree, YAML::anchor_t anchor) {
    if (anchor != 0) {
      Count(tree, tree.place);
      anchors_[anchor] = tree;
    }
    if (open_.empty()) {
      root_ = std::move(tree);
      return;
    }
    Level& level = open_.back();
    if (ExpectsKey()) {
      // The parser reports an unfinished list as a key before it finds the syntax error, so the check waits.
      if (tree.kind != Kind::kScalar && bad_key_.empty()) bad_key_ = tree.place;
      if (tree.kind == Kind::kScalar && !tree.quoted && tree.text == "<<")
        FailAt(tree.place,
               "the merge key '<<' is not part of YAML 1.2; repeat the keys, or inherit those of a "
               "file by `extends`");
      level.key = std::move(tree);
      return;
    }
    if (level.key) {
      tree.key = level.key->text;
      tree.key_place = level.key->place;
      level.key.reset();
    }
    level.tree.children.push_back(std::move(tree));
  }

  const YamlPlaceOf& place_of_;
  bool overridden_;
  std::shared_ptr<const std::filesystem::path> directory_;
  std::size_t values_ = 0;  // counted so far
  YamlTree root_;
  std::string bad_key_;  // place of the first key that is not a scalar
  int documents_ = 0;
  std::vector<Level> open_;
  std::map<YAML::anchor_t, YamlTree> anchors_;
};

}  // namespace

void CheckUtf8(std::string_view text, const YamlPlaceOf& place_of) {
  // A byte 0 is valid UTF-8 but indicates UTF-16.
  const auto bad = std::min(utf8::find_invalid(text.begin(), text.end()), std::ranges::find(text, '\0'));
  if (bad == text.end()) return;
  const std::string_view before(text.begin(), bad);
  const auto line = std::count(before.begin(), before.end(), '\n') + 1;
  const std::size_t last_break = before.rfind('\n');  // npos + 1 is 0
  FailAt(place_of(static_cast<int>(line), static_cast<int>(before.size() - (last_break + 1)) + 1),
         fmt::format("byte {:#04x} is not UTF-8; save the text in that encoding",
                     static_cast<unsigned char>(*bad)));
}

YamlTree ParseYamlTree(const std::string& text, const YamlPlaceOf& place_of, bool overridden,
                       const std::filesystem::path& directory) {
  if (text.size() > kMaxYamlBytes)
    FailAt(place_of(1, 1),
           fmt::format("the text has more than {} bytes; check that it is the right file", kMaxYamlBytes));
  CheckUtf8(text, place_of);
  TreeBuilder builder(place_of, overridden, directory);
  try {
    std::istringstream stream(text);
    YAML::Parser parser(stream);
    while (parser.HandleNextDocument(builder)) {
    }
  } catch (const YAML::Exception& error) {
    FailAt(place_of(error.mark.line + 1, error.mark.column + 1),
           fmt::format("not valid YAML: {}; correct the text here or just before", Excerpt(error.msg)));
  }
  return builder.Take();
}

std::optional<std::size_t> IndexIn(const YamlTree& list, std::string_view key) {
  if (list.kind != YamlTree::Kind::kList) return {};
  const auto index = NumberIn<std::size_t>(key);
  return index && *index < list.children.size() ? index : std::nullopt;
}

namespace {

/// Returns the child of a map or list that a word denotes, or null.
const YamlTree* ChildCalled(std::string_view word, const YamlTree& tree) {
  if (const auto index = IndexIn(tree, word)) return &tree.children[*index];
  if (tree.kind != YamlTree::Kind::kMap) return nullptr;
  const auto is_called = [&](const YamlTree& child) {
    return child.key == word || SplitUnit(child.key).first == word;
  };
  const auto child = std::ranges::find_if(tree.children, is_called);
  if (child != tree.children.end()) return &*child;
  // The key may have a unit that SplitUnit does not know, as in stiffness_mg_per_l.
  const auto begins = [&](const YamlTree& child) { return child.key.starts_with(std::string(word) + "_"); };
  const auto only = std::ranges::find_if(tree.children, begins);
  return !word.empty() && std::ranges::count_if(tree.children, begins) == 1 ? &*only : nullptr;
}

bool IsInWord(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
}

}  // namespace

const YamlTree& BlamedBy(const YamlTree& tree, std::string* path, std::string_view* message) {
  const YamlTree* blamed = &tree;
  for (std::string_view rest = *message;;) {
    const auto end = std::ranges::find_if_not(rest, IsInWord);
    const YamlTree* const child = ChildCalled({rest.begin(), end}, *blamed);
    if (child == nullptr) return *blamed;
    blamed = child;
    const std::string key =
        child->key.empty() ? std::string(rest.begin(), end) : child->key;  // index of a list
    *path += (path->empty() ? "" : ".") + key;
    rest = {end, rest.end()};
    if (rest.starts_with(": ")) {
      rest.remove_prefix(2);
      *message = rest;
    } else if (rest.starts_with('.')) {
      rest.remove_prefix(1);
    } else {
      return *blamed;
    }
  }
}

namespace {

/// Returns the file of a value, without line and column.
std::string_view FileOf(const YamlTree& tree) {
  const std::string_view place = tree.place;
  return place.substr(0, place.rfind(':', place.rfind(':') - 1));
}

/// Returns whether a value in `tree` comes from another file.
bool Inherits(const YamlTree& tree, const YamlTree& value) {
  return !tree.overridden && !value.overridden && FileOf(tree) != FileOf(value);
}

void ListOverrides(const YamlTree& tree, std::vector<std::string>& places) {
  if (tree.overridden && std::ranges::count(places, tree.place) == 0) places.push_back(tree.place);
  for (const YamlTree& child : tree.children) ListOverrides(child, places);
}

}  // namespace

const std::string& PlaceIn(const YamlTree& tree, const YamlTree& blamed) {
  return Inherits(tree, blamed) ? tree.place : blamed.place;
}

std::string WithOrigins(std::string_view message, const YamlTree& tree, const YamlTree& blamed) {
  std::vector<std::string> places;
  if (!tree.overridden) ListOverrides(tree, places);
  std::string text(message);
  for (const std::string& place : places)
    if (place != blamed.place) text += fmt::format(" (with {})", place);
  if (Inherits(tree, blamed)) text += fmt::format(" (inherited from {})", blamed.place);
  return text;
}

namespace {

/// Returns whether a scalar needs no quotes in flow style.
bool IsPlainInFlow(const YamlTree& scalar) {
  return !scalar.quoted && !scalar.text.empty() &&
         scalar.text.find_first_of(",[]{}#:'\"&*!|>%@`\\\n\t?") == std::string::npos;
}

std::string Quoted(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    if (const auto code = static_cast<unsigned char>(c); code < 0x20 || code == 0x7f) {
      quoted += fmt::format("\\x{:02x}", code);
    } else {
      quoted += c;
    }
  }
  return quoted + '"';
}

}  // namespace

std::string FlowText(const YamlTree& tree) {
  if (tree.kind == Kind::kNull) return "null";
  if (tree.kind == Kind::kScalar) return IsPlainInFlow(tree) ? tree.text : Quoted(tree.text);
  std::string text;
  for (const YamlTree& child : tree.children) {
    if (!text.empty()) text += ", ";
    if (tree.kind == Kind::kMap) text += Quoted(child.key) + ": ";
    text += FlowText(child);
  }
  return tree.kind == Kind::kMap ? "{" + text + "}" : "[" + text + "]";
}

bool IsPath(const YamlTree& tree) {
  return tree.kind == Kind::kScalar &&
         (tree.text.ends_with(".yaml") || tree.text.ends_with(".urdf") || tree.text.ends_with(".csv"));
}

std::string PathOf(const YamlTree& tree) {
  const std::filesystem::path path(tree.text);
  return std::filesystem::absolute(tree.directory ? *tree.directory / path : path)
      .lexically_normal()
      .string();
}

YamlTree WithAbsolutePaths(YamlTree tree, bool names_file) {
  const bool is_path =
      IsPath(tree) || (names_file && tree.kind == Kind::kScalar && tree.text.find('/') != std::string::npos);
  if (is_path) tree.text = PathOf(tree);
  for (YamlTree& child : tree.children)
    child = WithAbsolutePaths(std::move(child), names_file && child.key == "file");
  return tree;
}

YamlTree WithoutNulls(YamlTree tree) {
  if (tree.kind == Kind::kMap)
    std::erase_if(tree.children, [](const YamlTree& child) { return child.kind == Kind::kNull; });
  for (YamlTree& child : tree.children) child = WithoutNulls(std::move(child));
  return tree;
}

bool IsName(const YamlTree& tree) {
  if (tree.kind != Kind::kScalar || tree.text.empty() || tree.text == "true" || tree.text == "false")
    return false;
  double number = 0;
  return ParseNumber(tree.text, number) == std::errc::invalid_argument;
}

std::string Describe(const YamlTree& tree) {
  switch (tree.kind) {
    case Kind::kNull:
      return "nothing";
    case Kind::kScalar:
      return (tree.quoted ? "the quoted text '" : "'") + Excerpt(tree.text) + "'";
    case Kind::kList:
      return fmt::format("a list of {}", tree.children.size());
    case Kind::kMap:
      return "a map of keys and values";
  }
  return "";
}

void FailAt(std::string_view place, std::string_view what) {
  throw ParameterError(fmt::format("{}: {}", place, what));
}

}  // namespace tenon::internal
