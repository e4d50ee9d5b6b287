#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <tenon/systems/framework/fields.h>
#include <tenon/systems/yaml/yaml_node.h>

namespace tenon {
namespace internal {

/// Makes block-style YAML, lists in flow style, numbers with the fewest digits that give them back exactly.
class YamlWriter {
 public:
  YamlWriter();
  ~YamlWriter();
  std::string Text() const;

  void Write(double value);
  void Write(int value);
  void Write(std::uint64_t value);
  void Write(bool value);
  void Write(const std::string& value);
  template <NamedEnum E>
  void Write(const E& value) {
    for (const auto& [e, name] : EnumNames(value))
      if (e == value) return Write(std::string(name));
    FailUnnamed(static_cast<long long>(value));
  }
  template <class T>
  void Write(const std::optional<T>& value) {
    value ? Write(*value) : WriteNull();
  }
  template <class T>
  void Write(const std::vector<T>& value) {
    WriteList(value, HasFields<T>);
  }
  template <class T, std::size_t N>
  void Write(const std::array<T, N>& value) {
    WriteList(value, HasFields<T>);
  }
  template <class T>
  void Write(const std::map<std::string, T>& value) {
    BeginMap(value.empty());
    for (const auto& [key, item] : value) WriteKey(key), Write(item);
    EndMap();
  }
  template <int R, int C, int O>
  void Write(const Eigen::Matrix<double, R, C, O, R, C>& value) {
    BeginList(false);
    for (int r = 0; r < R; ++r) {
      if constexpr (C == 1) {
        Write(value(r, 0));
      } else {
        WriteList(std::vector<double>(value.row(r).begin(), value.row(r).end()), false);
      }
    }
    EndList();
  }
  template <HasFields T>
  void Write(const T& value) {
    BeginMap();
    ForEachField(value, [&](const auto& field, const auto& member) { WriteKey(field.name), Write(member); });
    EndMap();
  }
  template <class T>
  void Write(const T&) {
    static_assert(kHasYamlForm<T>, "no YAML form: a struct needs a static Fields(), an enum EnumNames()");
  }

 private:
  template <class List>
  void WriteList(const List& list, bool block) {
    BeginList(block);
    for (const typename List::value_type& item : list) Write(item);
    EndList();
  }
  void WriteNull();
  void WriteKey(const std::string& key);
  void BeginMap(bool empty = false);
  void EndMap();
  void BeginList(bool block);
  void EndList();
  [[noreturn]] void FailUnnamed(long long value) const;

  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace internal
}  // namespace tenon
