#pragma once

#include <tenon/systems/framework/types/internal/type_info.h>

#include <algorithm>
#include <filesystem>
#include <functional>

namespace tenon::internal {

/// A document as a tree of values with their places.
struct YamlTree {
  enum class Kind { kNull, kScalar, kList, kMap };

  Kind kind = Kind::kNull;
  std::string text;         // text of a scalar
  bool quoted = false;      // a quoted scalar is text even if it looks like a number
  std::string place;        // "robot.yaml:3:5" or "--set a.b=3"
  bool overridden = false;  // set by YamlDocument::Set
  std::string key;          // key of an entry of a map
  std::string key_place;    // place of the key
  std::shared_ptr<const std::filesystem::path> directory;  // directory of the file, base of relative paths
  std::vector<YamlTree> children;                          // items of a list or entries of a map

  template <class Tree>
  static auto FindKey(Tree& map, std::string_view key) {
    return std::ranges::find(map.children, key, &YamlTree::key);
  }
};

/// Returns the place of a line and a column, both counted from 1.
using YamlPlaceOf = std::function<std::string(int line, int column)>;

/// Throws ParameterError with the place of the first byte that is not UTF-8.
void CheckUtf8(std::string_view text, const YamlPlaceOf& place_of);

/// Limits of a document; a scenario has some hundred values. Keys count as values, and aliases and anchors
/// count as the values that they repeat.
constexpr std::size_t kMaxYamlBytes = 16 << 20;
constexpr std::size_t kMaxYamlValues = 500'000;

/// Parses one document; an empty one is null. Throws ParameterError on a syntax error, a key given twice,
/// a second document, a tag, text that is not UTF-8, and for more bytes or values than the limits allow.
/// `directory` is the base of relative paths.
YamlTree ParseYamlTree(const std::string& text, const YamlPlaceOf& place_of, bool overridden,
                       const std::filesystem::path& directory);

/// Writes a value on one line in flow style.
std::string FlowText(const YamlTree& tree);

/// Writes a text as a scalar, quoted unless every YAML reader takes it for this text.
std::string YamlScalar(const std::string& text);

/// Returns the index that a key denotes in a list; empty if it is not a number or too large.
std::optional<std::size_t> IndexIn(const YamlTree& list, std::string_view key);

/// Returns the value that a message is about. The message begins with a dotted key below `tree`, with or
/// without its unit: "mass = -1 must be positive" for mass_kg, "legs.2.mass: it is negative" for
/// legs.2.mass_kg. Appends the key to the path and removes it from the message if a colon follows. Returns
/// `tree` if there is no key.
const YamlTree& BlamedBy(const YamlTree& tree, std::string* path, std::string_view* message);

/// Returns the place of a message about the value `blamed` in `tree`. If `tree` inherits it from another
/// file, this is the place of `tree`.
const std::string& PlaceIn(const YamlTree& tree, const YamlTree& blamed);

/// Appends to a message the settings of --set in `tree` other than `blamed`, " (with --set a.b=3)", and the
/// place of `blamed` if `tree` inherits it, " (inherited from base.yaml:2:3)".
std::string WithOrigins(std::string_view message, const YamlTree& tree, const YamlTree& blamed);

/// Returns whether a value is a path: it ends in .yaml, .urdf or .csv.
bool IsPath(const YamlTree& tree);
/// Returns a value as an absolute path.
std::string PathOf(const YamlTree& tree);
/// Returns the value with absolute paths. If `tree` names a file (`names_file`), itself or by its entry
/// `file`, a name with a slash is a path, too.
YamlTree WithAbsolutePaths(YamlTree tree, bool names_file);

/// Returns the value without keys of maps that are null.
YamlTree WithoutNulls(YamlTree tree);

/// Returns whether a value can be a name: a text other than a number, true or false.
bool IsName(const YamlTree& tree);

/// Describes a value in a message: "nothing", "'text'", "a list of 3".
std::string Describe(const YamlTree& tree);

[[noreturn]] void FailAt(std::string_view place, std::string_view what);

}  // namespace tenon::internal

namespace tenon {
struct YamlFile;
struct YamlText;
}  // namespace tenon

namespace tenon::internal {

/// One value of a document and the dotted path to it. Its errors name the place and the path.
class YamlNode {
 public:
  /// With a scale, the keys and units of numbers are those of Field::Scaled. A part of a struct lacks keys
  /// and is not validated.
  YamlNode(const YamlTree& tree, std::string path, const Scale* scale = nullptr, bool is_part = false)
      : tree_(&tree), path_(std::move(path)), scale_(scale), is_part_(is_part) {}

  /// Reads into `value`, whose members hold the defaults. Throws ParameterError.
  void Read(const TypeInfo& type, void* value) const;

 private:
  void ReadNumber(const TypeInfo& type, void* value) const;
  void ReadDouble(double* value) const;
  template <class Integer>
  void ReadInteger(Integer* value) const;
  void ReadBool(bool* value) const;
  void ReadEnumerator(const TypeInfo& type, void* value) const;
  void ReadText(std::string* value) const;
  void ReadMatrix(const TypeInfo& type, void* value) const;
  void ReadStruct(const TypeInfo& type, void* value) const;
  void ReadField(const Field& field, void* value) const;
  void ReadRate(Rate* value) const;
  void ReadChanges(const TypeInfo& type, YamlText* value) const;
  void ReadItems(const TypeInfo& item, void* first, const std::vector<YamlNode>& items) const;
  void ReadFile(YamlFile* value) const;
  void ReadMap(const TypeInfo& type, void* value) const;

  bool IsNull() const { return tree_->kind == YamlTree::Kind::kNull; }
  bool IsList() const { return tree_->kind == YamlTree::Kind::kList; }
  std::vector<YamlNode> Items() const;                   ///< items of a list
  std::vector<YamlNode> Items(std::size_t count) const;  ///< items of a list of the given length
  std::optional<YamlNode> Find(std::string_view key) const;
  const char* KeyOf(const Field& field) const;
  /// Whether a default holds for one size only.
  static bool NeedsScale(const Field& field, const void* value);
  /// Throws for unknown and for missing keys. `value` holds the defaults.
  void CheckKeys(FieldList fields, const void* value) const;
  std::string Below(std::string_view key) const;  ///< the path to a key of this map
  YamlNode Child(const YamlTree& child, std::string_view key) const;
  [[noreturn]] void Fail(std::string_view what) const;
  [[noreturn]] void FailValidation(std::string_view what) const;

  const YamlTree* tree_;
  std::string path_;
  const Scale* scale_;
  bool is_part_;
};

}  // namespace tenon::internal
