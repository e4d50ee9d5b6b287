#pragma once

#include <tenon/systems/framework/types/internal/type_info.h>
#include <tenon/systems/yaml/internal/yaml_tree.h>

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tenon {
struct YamlFile;
}

namespace tenon::internal {

/// One value of a document and the dotted path to it. Its errors name the place and the path.
class YamlNode {
 public:
  YamlNode(const YamlTree& tree, std::string path) : tree_(&tree), path_(std::move(path)) {}

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
  void ReadItems(const TypeInfo& item, void* first, const std::vector<YamlNode>& items) const;
  void ReadFile(YamlFile* value) const;
  void ReadMap(const TypeInfo& type, void* value) const;

  bool IsNull() const { return tree_->kind == YamlTree::Kind::kNull; }
  bool IsList() const { return tree_->kind == YamlTree::Kind::kList; }
  std::vector<YamlNode> Items() const;                   ///< items of a list
  std::vector<YamlNode> Items(std::size_t count) const;  ///< items of a list of the given length
  std::optional<YamlNode> Find(std::string_view key) const;
  void CheckKeys(const FieldList& fields) const;  ///< throws for unknown and for missing keys
  std::string Below(std::string_view key) const;  ///< the path to a key of this map
  YamlNode Child(const YamlTree& child, std::string_view key) const;
  [[noreturn]] void Fail(std::string_view what) const;
  [[noreturn]] void FailValidation(std::string_view what) const;

  const YamlTree* tree_;
  std::string path_;
};

}  // namespace tenon::internal
