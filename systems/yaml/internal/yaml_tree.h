#pragma once

#include <algorithm>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tenon::internal {

/// A document as a tree of values, each with the place that it comes from.
struct YamlTree {
  enum class Kind { kNull, kScalar, kList, kMap };

  Kind kind = Kind::kNull;
  std::string text;                                        // of a scalar
  bool quoted = false;                                     // a quoted scalar is text, whatever it looks like
  std::string place;                                       // "robot.yaml:3:5" or "--set a.b=3"
  bool overridden = false;                                 // comes from Set
  std::string key;                                         // of an entry of a map
  std::string key_place;                                   // where the key stands
  std::shared_ptr<const std::filesystem::path> directory;  // of the file, from which paths in it start
  std::vector<YamlTree> children;                          // of a list or a map

  template <class Tree>
  static auto FindKey(Tree& map, std::string_view key) {
    return std::ranges::find(map.children, key, &YamlTree::key);
  }
};

/// Gives the place of a line and a column, both from 1.
using YamlPlaceOf = std::function<std::string(int line, int column)>;

/// Throws ParameterError with the place of the first byte that is not UTF-8.
void CheckUtf8(std::string_view text, const YamlPlaceOf& place_of);

/// What a document may hold; a scenario has some hundred values. Keys count, too, and aliases
/// and anchors as what they repeat.
constexpr std::size_t kMaxYamlBytes = 16 << 20;
constexpr std::size_t kMaxYamlValues = 500'000;

/// Parses one document; an empty one is null. Throws ParameterError on a syntax error, a key given twice,
/// a second document, a tag, text that is not UTF-8, and on more bytes or values than the above.
/// Paths in it start from `directory`.
YamlTree ParseYamlTree(const std::string& text, const YamlPlaceOf& place_of, bool overridden,
                       const std::filesystem::path& directory);

/// The value on one line, as YAML in flow style.
std::string FlowText(const YamlTree& tree);

/// The index that a key is in a list; none if it is no number, or too large.
std::optional<std::size_t> IndexIn(const YamlTree& list, std::string_view key);

/// What a message is about that begins with a key below `tree`, with or without its unit: "mass = -1 must be
/// positive" with mass_kg, "legs.2.mass: it is negative" with legs.2.mass_kg. Appends that to the path, and
/// takes it out of the message if a colon comes behind it. The tree itself if it begins with none.
const YamlTree& BlamedBy(const YamlTree& tree, std::string* path, std::string_view* message);

/// The message, and what in `tree` was set by --set, unless that is `blamed` itself: " (with --set a.b=3)".
std::string WithOverrides(std::string_view message, const YamlTree& tree, const YamlTree& blamed);

/// Whether a value is a path: it ends in .yaml, .urdf or .csv.
bool IsPath(const YamlTree& tree);
/// The path that a value is, absolute.
std::string PathOf(const YamlTree& tree);
/// The value with all paths in it absolute. Where a file is named, by `tree` itself or by its entry `file`,
/// all that holds a slash is a path, too.
YamlTree WithAbsolutePaths(YamlTree tree, bool names_file);

/// Whether a value is a word that may name something: no number, and neither true nor false.
bool IsName(const YamlTree& tree);

/// "nothing", "'abc'", "a list of 3": what was found, for messages.
std::string Describe(const YamlTree& tree);

[[noreturn]] void FailAt(std::string_view place, std::string_view what);

}  // namespace tenon::internal
