#pragma once

#include <tenon/systems/framework/types/errors.h>
#include <tenon/systems/framework/types/internal/type_info.h>

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace tenon {

namespace internal {
struct YamlTree;
std::string WriteYaml(const TypeInfo& type, const void* value);
}  // namespace internal

/// Throws ParameterError, with `place`, line and column, unless the text is UTF-8.
void CheckUtf8(std::string_view text, const std::string& place);

/// Any value of a YAML file, kept as text: a member of a struct whose type is not known when it is read.
struct YamlText {
  std::string text{};  ///< on one line, so that Set() takes it; paths in it are absolute
};

/// Another file that a YAML file names, as text on one line: a word for one that ships, a path, or a map that
/// says which file, by one of these, and what is different in it, `{file: cdpr_4, mass_kg: 6}`. Paths are
/// absolute once they are read. A map without `file` changes the file that the default names.
struct YamlFile {
  std::string text{};
};

/// The version of the files that are read and written; files that do not say theirs have this one. It goes up
/// when an older reader would take a file for something else.
inline constexpr int kYamlFormat = 1;

/// A key that a file had in an earlier version, and what it is called now; dotted.
struct RenamedKey {
  const char* key;
  const char* successor;
};

/// A YAML file of parameters, read strictly into structs that describe themselves by a static `Fields()`:
///
///     struct WalkParams {
///       double speed_m_per_s = 0.2;
///       Eigen::Vector3d goal_m = Eigen::Vector3d::Zero();
///       static FieldList Fields() {
///         return {{"speed_m_per_s", &WalkParams::speed_m_per_s},
///                           Required("goal_m", &WalkParams::goal_m)};
///       }
///       void Validate() const;  // optional, called after reading; throws ParameterError, best with a
///                               // message that begins with the key, which is looked up in the file then
///     };
///     auto document = YamlDocument::Load("walk.yaml");
///     document.Set("speed_m_per_s", "0.3");
///     const auto params = document.Read<WalkParams>();
///
/// A member is a double, int, std::uint64_t, bool, std::string, an enum with EnumNames() (see NamedEnum), an
/// Eigen vector or matrix of fixed size, another struct with Fields(), YamlText, YamlFile, or a std::optional
/// (null is empty), std::vector, std::array or std::map<std::string, ...> of those.
///
/// A value that ends in .yaml, .urdf or .csv is a path. It starts from the directory of the file in which it
/// stands, wherever that is read from and by what it is extended; from the working directory where Set() gave
/// it.
///
/// A file may say `format: 1`, the version that it was written for; a newer one than kYamlFormat is refused.
/// A struct with a static `std::vector<RenamedKey> Renamed()` tells the writer of an old file what a key is
/// called now.
///
/// A key that is left out keeps its default unless it is Required. Refused are keys that the struct does not
/// have, keys given twice, values of another type or length, numbers that are not finite, and what Validate()
/// refuses. Every error is a ParameterError that begins with file, line, column and the path of the key, as
/// in `plant.yaml:12:5: masses.2.place_m: expected a list of 3, found a list of 2`.
class YamlDocument {
 public:
  /// Reads a file. Throws if it cannot be read, is not valid YAML or holds more than one document.
  static YamlDocument Load(const std::string& path);
  /// The same from text; errors call it `name`.
  static YamlDocument Parse(std::string text, std::string name);
  const std::string& name() const { return name_; }

  /// Replaces one value, as `--set a.b=3` of a command line asks: `value_text` is YAML, the key a path of map
  /// keys and list indices (`anchors.2`). A map key that is missing is added, a list does not grow; a name
  /// becomes a map of what differs: `robot: cdpr_4` by `robot.mass_kg=6` {file: cdpr_4, mass_kg: 6}.
  /// Errors that stem from the value say `--set a.b=3` instead of a line of the file.
  void Set(std::string_view dotted_key, std::string_view value_text);

  /// Adds what `base` says and this document does not: maps key by key, while lists and scalars of this
  /// document stand for those of the base. A map without `file` that stands for a name says what differs in
  /// the file of that name.
  void AddMissing(const YamlDocument& base);
  /// Takes out a key at top level, if it is there.
  void Remove(std::string_view key);

  /// Where the value of a key stands, as errors begin: "walk.yaml:12:5: path.points". For what is found wrong
  /// after reading. Of a key that is not there, where it would be.
  std::string PlaceOf(std::string_view dotted_key) const;
  /// A message as errors begin and go on, "walk.yaml:12:5: path.points: no three of them may…", of what is
  /// wrong with the value of a key, or with that below it with whose key the message begins, with or without
  /// its unit: "num_steps = 1 must be…". Begins with the name of the document if neither says a key.
  std::string Placed(std::string_view dotted_key, std::string_view message) const;

  /// The text of a scalar at top level; empty if there is none of that key.
  std::string Text(std::string_view key) const;
  /// A path under a key at top level, absolute; empty if there is none of that key.
  std::string Path(std::string_view key) const;
  /// All paths in it, absolute, by dotted keys.
  std::vector<std::pair<std::string, std::string>> Paths() const;
  /// The same document with absolute paths.
  YamlDocument WithAbsolutePaths() const;
  /// All of it on one line, in flow style and without comments.
  std::string Flow() const;
  /// The keys of the map under a key, in the order of the file; none if it is no map.
  std::vector<std::string> Keys(std::string_view dotted_key) const;

  /// The value of a key as Flow() writes it; empty if there is none of that key.
  std::string Value(std::string_view dotted_key) const;
  /// All values but maps, as Flow() writes them, by dotted keys.
  std::vector<std::pair<std::string, std::string>> Values() const;

  /// Draws what the document leaves to chance: wherever it says one of
  ///
  ///     mass_error_ratio: {uniform: [-0.3, 0.3]}     # low, high
  ///     mass_kg: {normal: [5, 0.5]}                  # mean, standard deviation
  ///     friction: {lognormal: [-0.5, 0.2]}           # those of the logarithm
  ///
  /// a number takes its place, which follows from the seed and the key. Returns what was drawn, by dotted
  /// keys. Throws ParameterError with the place of a distribution that makes no sense.
  std::vector<std::pair<std::string, double>> Draw(std::uint64_t seed);

  /// Reads the document into a T that holds its defaults.
  template <HasFields T>
  T Read() const {
    T value{};
    ReadInto(value);
    return value;
  }
  /// Reads over `value`, whose members are the defaults; after an error it is unchanged.
  template <HasFields T>
  void ReadInto(T& value) const {
    if constexpr (requires { T::Renamed(); }) RefuseRenamed(T::Renamed());
    T read = value;
    Read(internal::TypeInfoOf<T>(), &read);
    value = std::move(read);
  }

 private:
  YamlDocument(std::shared_ptr<const internal::YamlTree> tree, std::string name)
      : tree_(std::move(tree)), name_(std::move(name)) {}
  void Read(const internal::TypeInfo& type, void* value) const;
  void RefuseRenamed(const std::vector<RenamedKey>& renamed) const;
  void CheckFormat() const;

  std::shared_ptr<const internal::YamlTree> tree_;  ///< never changed, so copies may share it
  std::string name_;
};

/// YAML text with every field of `value`: YamlDocument::Parse gives back an equal value, bit for bit.
/// Throws ParameterError for numbers that are not finite, for these could not be read again.
template <HasFields T>
std::string WriteYaml(const T& value) {
  return internal::WriteYaml(internal::TypeInfoOf<T>(), &value);
}

}  // namespace tenon
