#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include <tenon/systems/framework/errors.h>
#include <tenon/systems/framework/fields.h>

namespace tenon {

/// An enum that YAML knows by names. Beside the enum stands, say,
///
///     constexpr auto EnumNames(WinchMode) {
///       return std::array{std::pair{WinchMode::kTension, "tension"}, std::pair{WinchMode::kTorque,
///       "torque"}};
///     }
template <class E>
concept NamedEnum = std::is_enum_v<E> && requires(E e) {
  EnumNames(e);
};

/// The name of an enumerator; "?" for a value that has none.
template <NamedEnum E>
constexpr const char* EnumName(E value) {
  for (const auto& [e, name] : EnumNames(value)) {
    if (e == value) return name;
  }
  return "?";
}

namespace internal {

struct YamlTree;
struct YamlKey {
  const char* name;
  bool required;
};
template <class>
inline constexpr bool kHasYamlForm = false;

/// One value of a document and the dotted path to it; what it throws names the place and the path.
class YamlNode {
 public:
  YamlNode(const YamlTree& tree, std::string path) : tree_(&tree), path_(std::move(path)) {}

  void Read(double& value) const;
  void Read(int& value) const;
  void Read(std::uint64_t& value) const;
  void Read(bool& value) const;
  void Read(std::string& value) const;
  template <NamedEnum E>
  void Read(E& value) const {
    std::vector<std::string_view> names;
    for (const auto& [e, name] : EnumNames(E{})) names.push_back(name);
    value = EnumNames(E{})[IndexIn(names)].first;
  }
  template <class T>
  void Read(std::optional<T>& value) const {
    value.reset();
    if (!IsNull()) Read(value.emplace());
  }
  template <class T>
  void Read(std::vector<T>& value) const {
    value.clear();
    for (const YamlNode& item : Items()) {
      T read{};
      item.Read(read);
      value.push_back(std::move(read));
    }
  }
  template <class T, std::size_t N>
  void Read(std::array<T, N>& value) const {
    const std::vector<YamlNode> items = Items(N);
    for (std::size_t i = 0; i < N; ++i) items[i].Read(value[i]);
  }
  template <class T>
  void Read(std::map<std::string, T>& value) const {
    value.clear();
    for (const auto& [key, node] : Entries()) node.Read(value[key]);
  }
  /// A vector is a list; a matrix is a list of rows, or the list of its diagonal.
  template <int R, int C, int O>
  void Read(Eigen::Matrix<double, R, C, O, R, C>& value) const {
    static_assert(R > 0 && C > 0, "only vectors and matrices of fixed size are read from YAML");
    const std::vector<YamlNode> items = Items(R);
    const bool diagonal = R == C && !items[0].IsList();
    value.setZero();
    for (int r = 0; r < R; ++r) {
      if (C == 1 || diagonal) {
        items[r].Read(value(r, C == 1 ? 0 : r));
      } else {
        const std::vector<YamlNode> row = items[r].Items(C);
        for (int c = 0; c < C; ++c) row[c].Read(value(r, c));
      }
    }
  }
  template <HasFields T>
  void Read(T& value) const {
    std::vector<YamlKey> keys;
    ForEachField(value, [&](const auto& field, auto&) { keys.push_back({field.name, field.required}); });
    CheckKeys(keys);
    ForEachField(value, [&](const auto& field, auto& member) {
      if (const auto node = Find(field.name)) node->Read(member);
    });
    if constexpr (requires { std::as_const(value).Validate(); }) {
      try {
        std::as_const(value).Validate();
      } catch (const ParameterError& error) {
        FailValidation(error.what());
      }
    }
  }
  template <class T>
  void Read(T&) const {
    static_assert(kHasYamlForm<T>, "no YAML form: a struct needs a static Fields(), an enum EnumNames()");
  }

 private:
  bool IsNull() const;
  bool IsList() const;
  std::vector<YamlNode> Items() const;                   ///< of a list
  std::vector<YamlNode> Items(std::size_t count) const;  ///< of a list of that length
  std::vector<std::pair<std::string, YamlNode>> Entries() const;
  std::optional<YamlNode> Find(std::string_view key) const;
  std::size_t IndexIn(std::span<const std::string_view> names) const;
  void CheckKeys(std::span<const YamlKey> keys) const;  ///< throws on unknown and on missing ones
  YamlNode Child(const YamlTree& child, std::string_view key) const;
  [[noreturn]] void Fail(std::string_view what) const;
  [[noreturn]] void FailValidation(std::string_view what) const;

  const YamlTree* tree_;
  std::string path_;
};

}  // namespace internal
}  // namespace tenon
