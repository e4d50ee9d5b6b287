#pragma once

#include <tenon/systems/framework/types/internal/type_info.h>
#include <tenon/systems/yaml/internal/yaml_tree.h>

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
