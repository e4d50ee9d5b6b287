#include <tenon/apps/common/scenario_file.h>
#include <tenon/systems/files/input_file.h>
#include <tenon/systems/files/output_file.h>
#include <tenon/systems/text/text.h>
#include <tenon/systems/version.h>
#include <tenon/systems/yaml/mesh_paths.h>
#include <tenon/systems/yaml/resources.h>

#include <fmt/core.h>

#include <algorithm>
#include <functional>
#include <sstream>

namespace tenon::apps {

namespace fs = std::filesystem;

namespace {

constexpr const char* kFiles = "files";       // directory of copies beside scenario.yaml
constexpr const char* kWritten = ".written";  // lists the copies, so that nothing else is removed

fs::path FindScenario(const std::string& name, const std::string& app);

/// Loads a scenario with the keys that it inherits by `extends`. Lists the files that it reads.
YamlDocument LoadExtended(const std::string& file, const std::string& app,
                          std::vector<std::string>* files = nullptr) {
  YamlDocument document = YamlDocument::Load(file);
  std::vector<std::string> chain{fs::absolute(file).lexically_normal().string()};
  while (true) {
    const std::string name = document.Text("extends");
    if (name.empty()) {
      if (files != nullptr) *files = std::move(chain);
      return document;
    }
    const std::string place = document.PlaceOf("extends");
    try {
      const std::string base =
          IsResourcePath(name) ? document.Path("extends") : FindScenario(name, app).string();
      if (std::ranges::count(chain, base) > 0)
        throw ParameterError(fmt::format("scenario '{}' extends itself through '{}': remove one `extends`",
                                         internal::Excerpt(base), internal::Excerpt(chain.back())));
      chain.push_back(base);
      const YamlDocument whole = YamlDocument::Load(base);
      document.Remove("extends");
      document.AddMissing(whole);
    } catch (const ParameterError& error) {
      throw ParameterError(fmt::format("{}: {}", place, error.what()));
    }
  }
}

/// Returns the path of a scenario. Finds scenarios of other apps, too, which the caller refuses.
fs::path FindScenario(const std::string& name, const std::string& app) {
  if (IsResourcePath(name)) return name;
  if (std::ranges::count(ListResources("scenarios"), name) > 0) return FindResource("scenarios", name);
  std::vector<std::string> names;
  for (const auto& [own, description] : ListScenarios(app)) names.push_back(own);
  if (names.empty())
    throw ParameterError(
        fmt::format("there is no '{}': {} has no shipped scenarios; give the path of a .yaml file", name,
                    app.empty() ? "this program" : app));
  return FindResource("scenarios", name, names);
}

/// Visits all files that a value names, with their dotted keys.
void ForEachFile(const internal::TypeInfo& type, void* value, const std::string& key,
                 const std::function<void(const std::string& key, YamlFile& file)>& visit) {
  using Kind = internal::TypeInfo::Kind;
  const auto below = [&](const std::string& name) { return key.empty() ? name : key + "." + name; };
  if (type.kind == Kind::kOpaque && *type.id == typeid(YamlFile)) visit(key, *static_cast<YamlFile*>(value));
  if (type.kind == Kind::kStruct)
    for (const Field& field : type.fields)
      ForEachFile(field.type(), static_cast<std::byte*>(value) + field.offset, below(field.name), visit);
  const bool optional = type.kind == Kind::kOptional;
  if (!optional && type.kind != Kind::kArray && type.kind != Kind::kList) return;
  std::size_t count = type.count, cols = 1;
  if (type.kind != Kind::kArray) type.shape(value, &count, &cols);
  void* const first = type.kind == Kind::kArray || count == 0 ? value : type.data(value);
  for (std::size_t i = 0; i < count; ++i)
    ForEachFile(type.item(), static_cast<std::byte*>(first) + i * type.item().size,
                optional ? key : below(std::to_string(i)), visit);
}

}  // namespace

std::vector<std::pair<std::string, std::string>> ListScenarios(const std::string& app) {
  std::vector<std::pair<std::string, std::string>> scenarios;
  for (const std::string& name : ListResources("scenarios")) {
    const YamlDocument document = LoadExtended(FindResource("scenarios", name), app);
    if (document.Text("app") == app) scenarios.emplace_back(name, document.Text("description"));
  }
  return scenarios;
}

void ApplySettings(const std::vector<std::string>& settings, YamlDocument* document) {
  for (const std::string& setting : settings) {
    const std::size_t equals = setting.find('=');
    if (equals == std::string::npos || equals == 0) {
      throw ParameterError(
          fmt::format("--set {}: write key=value, as in --set duration_s=5", internal::Excerpt(setting)));
    }
    document->Set(setting.substr(0, equals), setting.substr(equals + 1));
  }
}

YamlDocument LoadScenario(const std::string& name, const std::vector<std::string>& settings,
                          const std::string& app, std::vector<std::string>* files) {
  YamlDocument document = LoadExtended(FindScenario(name, app), app, files);
  ApplySettings(settings, &document);
  if (const std::string other = document.Text("app"); !app.empty() && !other.empty() && other != app) {
    throw ParameterError(fmt::format("{0}: '{1}' is not a scenario of {2}; run {3} {1}",
                                     document.PlaceOf("app"), internal::Excerpt(name), app,
                                     internal::Excerpt(other)));
  }
  return document;
}

std::vector<std::pair<std::string, double>> DrawScenario(YamlDocument& scenario,
                                                         std::optional<std::uint64_t> seed) {
  if (seed) {
    scenario.Set("seed", fmt::format("{}", *seed));
  } else {
    // The default seed is 1. An invalid seed is refused when the scenario is read.
    const std::string text = scenario.Text("seed");
    seed = internal::NumberIn<std::uint64_t>(internal::WithoutPlus(text)).value_or(1);
  }
  return scenario.Draw(*seed);
}

void ScenarioFiles::Take(const internal::TypeInfo& type, void* scenario) {
  ForEachFile(type, scenario, "", [this](const std::string& key, YamlFile& file) { Take(key, file); });
  text_ = fmt::format("format: {}\n{}", kYamlFormat, internal::WriteYaml(type, scenario));
}

void ScenarioFiles::Take(const std::string& key, YamlFile& file) {
  YamlDocument map = ResourceMap(file);
  const std::size_t before = files_.size();
  const auto copy = [&](const std::string& inner, const fs::path& path) {
    std::ifstream in = OpenInput(path, std::ios::binary);
    if (!in.is_open()) return;  // not the path of a file
    const std::string ending = path.extension().string();
    const std::string name = inner == "file" ? key : key + "." + inner;
    std::string text(std::istreambuf_iterator<char>(in), {});
    if (ending == ".urdf") text = WithMeshesFound(std::move(text), path);
    files_.emplace_back(name.ends_with(ending) ? name : name + ending, std::move(text));
    map.Set(inner, fmt::format("{}/{}", kFiles, files_.back().first));
  };
  const std::string path = map.Text("file");
  std::vector<std::string> said = map.Keys("");
  for (const auto& [inner, inner_path] : map.Paths()) copy(inner, inner_path);
  if (!IsResourcePath(path)) {
    if (files_.size() > before) file.text = map.Flow();
    return;
  }
  if (path.ends_with(".yaml"))
    for (const auto& [inner, inner_path] : YamlDocument::Load(path).Paths())
      if (std::ranges::count(said, inner) == 0) copy(inner, inner_path);
  file.text = map.Keys("").size() > 1 ? map.Flow() : map.Text("file");
}

/// Removes the copies that an earlier run wrote.
static void RemoveWritten(const fs::path& place) {
  std::istringstream written(ReadText(place / kWritten));
  std::error_code ignored;  // remaining files do no harm
  for (std::string name; std::getline(written, name);) fs::remove(place / fs::path(name).filename(), ignored);
  fs::remove(place / kWritten, ignored);
  fs::remove(place, ignored);  // fails if it holds other files
}

void ScenarioFiles::Write(const fs::path& directory) const {
  const fs::path place = directory / kFiles;
  RemoveWritten(place);
  if (!files_.empty()) {
    std::error_code ignored;  // on failure, WriteFile throws
    fs::create_directory(place, ignored);
    std::string names;
    for (const auto& [name, text] : files_) names += name + "\n";
    WriteFile(place / kWritten, names);
  }
  for (const auto& [name, text] : files_) WriteFile(place / name, text);
  WriteFile(directory / "scenario.yaml", fmt::format("# Tenon {}\n{}", Version(), text_));
}

/// Returns the key called `name` in the outermost map that has one; empty if there is none.
static std::string FindKey(const YamlDocument& scenario, std::string_view name) {
  std::vector<std::string> paths = scenario.Keys("");
  for (std::size_t i = 0; i < paths.size(); ++i) {
    const std::string path = paths[i];
    if (path.substr(path.rfind('.') + 1) == name) return path;
    for (const std::string& key : scenario.Keys(path)) paths.push_back(path + "." + key);
  }
  return {};
}

/// Returns the key called like a block, or like the innermost diagram around it that has a key.
static std::string KeyOfBlock(const YamlDocument& scenario, std::string_view path) {
  while (!path.empty()) {
    const std::size_t dot = path.rfind('.');
    if (std::string key = FindKey(scenario, path.substr(dot + 1)); !key.empty()) return key;
    path = path.substr(0, dot == path.npos ? 0 : dot);
  }
  return {};
}

/// Removes the place in a ResourceMap from a message, because that map is part of the scenario.
static std::string_view WithoutPlaceInMap(std::string_view message) {
  if (!message.starts_with(kChanges)) return message;
  const std::size_t end = message.find(": ");
  return end == message.npos ? message : message.substr(end + 2);
}

void ThrowWithPlace(const YamlDocument& scenario, const KeyError& error) {
  const std::string key = error.key().empty() ? KeyOfBlock(scenario, error.block()) : error.key();
  throw ParameterError(scenario.Placed(key, WithoutPlaceInMap(error.what())));
}

}  // namespace tenon::apps
