#pragma once

#include <tenon/systems/framework/types/errors.h>
#include <tenon/systems/framework/types/internal/type_info.h>

namespace tenon {

namespace internal {
struct YamlTree;
std::string WriteYaml(const TypeInfo& type, const void* value);
}  // namespace internal

/// Throws ParameterError, with `place`, line and column, unless the text is UTF-8.
void CheckUtf8(std::string_view text, const std::string& place);

/// Any value of a YAML file, kept as text, for members whose type is not known when the file is read.
struct YamlText {
  std::string text{};  ///< on one line, as Set() requires; paths are absolute
};

/// A reference to another file, as text on one line: the name of a shipped resource, a path, or a map with
/// the file and changes to it, `{file: cdpr_4, mass_kg: 6}`. Paths become absolute when they are read. A map
/// without `file` changes the file that the default names.
struct YamlFile {
  std::string text{};
};

/// Keys of a T that replace those of a file: `sensors: {imu: {rate_hz: 500}}` beside `hardware: standard`.
/// They are checked when they are read, and kept as text for YamlDocument::Change. Null means not set.
/// `kScaled`: numbers have the keys and units of Field::Scaled.
template <class T, bool kScaled = false>
struct YamlChanges : YamlText {
  using Changed = T;
  static constexpr bool kHasScale = kScaled;
};

/// The version of the file format. Files without the key `format` have this version. It increases when an
/// older reader would misread new files.
inline constexpr int kYamlFormat = 1;

/// The dotted key of an earlier version and its present name.
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
///         return {Field("speed_m_per_s", &WalkParams::speed_m_per_s).AtLeast(0).Below(2),
///                 Required("goal_m", &WalkParams::goal_m)};
///       }
///       void Validate() const;  // optional, called after reading; throws ParameterError. If the
///                               // message begins with a key, the error names its place in the file
///     };
///     auto document = YamlDocument::Load("walk.yaml");
///     document.Set("speed_m_per_s", "0.3");
///     const auto params = document.Read<WalkParams>();
///
/// A member is a double, int, std::uint64_t, bool, std::string, an enum with EnumNames() (see NamedEnum), an
/// Eigen vector or matrix of fixed size, a Rate (in Hz), another struct with Fields(), YamlText, YamlFile,
/// YamlChanges, or a std::optional (null is empty), std::vector, std::array or std::map<std::string, ...> of
/// those.
///
/// A value that ends in .yaml, .urdf or .csv is a path. It is relative to the directory of the file that
/// contains it, or to the working directory if Set() gave it.
///
/// A file may have the key `format: 1`, its version; versions above kYamlFormat are refused. A struct with a
/// static `std::vector<RenamedKey> Renamed()` makes errors name the new key for a renamed one.
///
/// A missing key keeps its default unless it is Required. Reading throws ParameterError for unknown and
/// duplicate keys, values of the wrong type or length, numbers that are not finite or out of range, and
/// errors of Validate(). The message begins with file, line, column and the path of the key, as in
/// `plant.yaml:12:5: masses.2.place_m: expected a list of 3, found a list of 2`.
class YamlDocument {
 public:
  /// Reads a file. Throws ParameterError if it cannot be read, is not valid YAML or holds several documents.
  static YamlDocument Load(const std::string& path);
  /// Parses a text; errors call it `name`. Throws ParameterError as Load does.
  static YamlDocument Parse(std::string text, std::string name);
  const std::string& name() const { return name_; }

  /// Replaces one value as the option `--set a.b=3` does. `value_text` is YAML; the key is a path of map keys
  /// and list indices (`anchors.2`). Missing map keys are added; lists do not grow. A name becomes a map of
  /// changes: `robot.mass_kg=6` turns `robot: cdpr_4` into {file: cdpr_4, mass_kg: 6}. Errors in the value
  /// name the option `--set a.b=3` instead of a line of the file.
  void Set(std::string_view dotted_key, std::string_view value_text);

  /// Adds the keys of `base` that this document lacks, recursively in maps; lists and scalars of this
  /// document replace those of the base. A map without `file` that replaces a name becomes a map of changes
  /// to the file of that name.
  void AddMissing(const YamlDocument& base);
  /// Sets the keys of a map, recursively, which a scenario gives beside this file, and removes keys that are
  /// null: they are not set.
  void Change(std::string_view dotted_key, const YamlText& changes);
  /// Removes a key at top level, if it exists.
  void Remove(std::string_view key);

  /// Returns the place and path of a key, with which errors begin: "walk.yaml:12:5: path.points". The place
  /// of a missing key is that of the map which lacks it.
  std::string PlaceOf(std::string_view dotted_key) const;
  /// Prefixes a message about the value of a key with its place, "walk.yaml:12:5: path.points: no three…". If
  /// the message begins with a key below this one, with or without unit ("num_steps = 1 must be…"), that
  /// key's place is used. Without any key, the prefix is the name of the document.
  std::string Placed(std::string_view dotted_key, std::string_view message) const;

  /// Returns the text of a scalar at top level; empty if the key is missing.
  std::string Text(std::string_view key) const;
  /// Returns the absolute path under a key at top level; empty if the key is missing.
  std::string Path(std::string_view key) const;
  /// Returns all paths in the document, absolute, by dotted keys.
  std::vector<std::pair<std::string, std::string>> Paths() const;
  /// Returns the document with absolute paths.
  YamlDocument WithAbsolutePaths() const;
  /// Returns the document on one line in flow style, without comments.
  std::string Flow() const;
  /// Returns the keys of the map under a key in the order of the file; empty if the value is not a map.
  std::vector<std::string> Keys(std::string_view dotted_key) const;

  /// Returns the value of a key in the format of Flow(); empty if the key is missing.
  std::string Value(std::string_view dotted_key) const;
  /// Returns all values except maps in the format of Flow(), by dotted keys.
  std::vector<std::pair<std::string, std::string>> Values() const;

  /// Draws random values. It replaces each distribution
  ///
  ///     mass_error_ratio: {uniform: [-0.3, 0.3]}     # low, high
  ///     mass_kg: {normal: [5, 0.5]}                  # mean, standard deviation
  ///     friction: {lognormal: [-0.5, 0.2]}           # mean, standard deviation of the logarithm
  ///
  /// by a number that depends on the seed and the key. Returns the drawn numbers by dotted keys. Throws
  /// ParameterError with the place of an invalid distribution.
  std::vector<std::pair<std::string, double>> Draw(std::uint64_t seed);

  /// Reads the document into a default-constructed T.
  template <HasFields T>
  T Read(const Scale* scale = nullptr) const {
    T value{};
    ReadInto(value, scale);
    return value;
  }
  /// Reads the map under a key into a default-constructed T. A missing key counts as an empty map.
  template <HasFields T>
  T ReadAt(std::string_view dotted_key) const {
    T value{};
    Read(dotted_key, internal::TypeInfoOf<T>(), &value, nullptr);
    return value;
  }
  /// Reads into `value`, whose members hold the defaults. An error leaves it unchanged.
  /// With a scale, numbers have the keys and units of Field::Scaled and are converted.
  template <HasFields T>
  void ReadInto(T& value, const Scale* scale = nullptr) const {
    if constexpr (requires { T::Renamed(); }) RefuseRenamed(T::Renamed());
    T read = value;
    Read("", internal::TypeInfoOf<T>(), &read, scale);
    value = std::move(read);
  }

 private:
  YamlDocument(std::shared_ptr<const internal::YamlTree> tree, std::string name)
      : tree_(std::move(tree)), name_(std::move(name)) {}
  void Read(std::string_view dotted_key, const internal::TypeInfo& type, void* value,
            const Scale* scale) const;
  void RefuseRenamed(const std::vector<RenamedKey>& renamed) const;
  void CheckFormat() const;

  std::shared_ptr<const internal::YamlTree> tree_;  ///< immutable, so copies share it
  std::string name_;
};

/// Returns YAML text with every field of `value`, which YamlDocument::Parse reads back bit for bit. Throws
/// ParameterError for numbers that are not finite.
template <HasFields T>
std::string WriteYaml(const T& value) {
  return internal::WriteYaml(internal::TypeInfoOf<T>(), &value);
}

}  // namespace tenon
