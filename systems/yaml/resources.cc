#include <tenon/systems/files/input_file.h>
#include <tenon/systems/text/text.h>
#include <tenon/systems/yaml/resources.h>
#include <tenon/systems/yaml/yaml.h>

#include <dlfcn.h>
#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace tenon {

namespace fs = std::filesystem;

fs::path DataDirectory() {
  if (const char* own = std::getenv("TENON_DATA_DIR"); own != nullptr) return own;
  Dl_info info;
  if (dladdr(reinterpret_cast<const void*>(&DataDirectory), &info) != 0) {
    const fs::path here = fs::path(info.dli_fname).parent_path();
    for (const char* way : {TENON_LIBRARY_TO_DATA, TENON_PROGRAM_TO_DATA}) {
      if (fs::exists(here / way)) return fs::weakly_canonical(here / way);
    }
  }
  return TENON_BUILD_DATA_DIR;
}

std::vector<std::string> ListResources(const std::string& kind) {
  std::vector<std::string> names;
  const fs::path directory = DataDirectory() / kind;
  if (!fs::is_directory(directory)) {
    throw ParameterError(
        fmt::format("there is no directory '{}': set TENON_DATA_DIR to the installation's share/tenon",
                    directory.string()));
  }
  for (const auto& entry : fs::directory_iterator(directory)) {
    if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

bool IsResourcePath(const std::string& name) {
  return name.ends_with(".yaml") || name.find('/') != std::string::npos;
}

/// The path of the file, or the path at which a file of that name would ship.
static fs::path PathOfResource(const std::string& kind, const std::string& name) {
  return IsResourcePath(name) ? fs::path(name) : DataDirectory() / kind / (name + ".yaml");
}

static bool HasKey(const YamlDocument& document, const std::string& key) {
  return std::ranges::count(document.Keys(""), key) > 0;
}

std::vector<std::string> ListResources(const std::string& kind, const std::string& key) {
  std::vector<std::string> names = ListResources(kind);
  std::erase_if(names, [&](const std::string& name) {
    return !HasKey(YamlDocument::Load(PathOfResource(kind, name)), key);
  });
  return names;
}

YamlDocument ResourceMap(const YamlFile& what) {
  const bool is_map = what.text.starts_with('{');
  return YamlDocument::Parse(is_map ? what.text : "file: " + what.text, kChanges);
}

std::string ResourceName(const YamlFile& what) {
  const YamlDocument map = ResourceMap(what);
  return map.Text("file") + (map.Keys("").size() > 1 ? ", changed" : "");
}

YamlDocument LoadResource(const std::string& kind, const YamlFile& what, const std::string& key) {
  YamlDocument overlay = ResourceMap(what);
  const std::string name = overlay.Text("file");
  if (name.empty()) throw ParameterError("a map of changes needs the key `file`, as in {file: standard, …}");
  const fs::path path = PathOfResource(kind, name);
  const bool must_exist = !IsResourcePath(name);
  if (must_exist && !fs::exists(path))
    FindResource(kind, name, key.empty() ? ListResources(kind) : ListResources(kind, key));  // throws
  const YamlDocument whole = YamlDocument::Load(path);
  if (must_exist && !key.empty() && !HasKey(whole, key))
    throw ParameterError(fmt::format("'{}' in {} has no key '{}'; choose one of: {}", name, kind, key,
                                     fmt::join(ListResources(kind, key), ", ")));
  if (overlay.Keys("").size() == 1) return whole;
  overlay.Remove("file");
  overlay.AddMissing(whole);
  return overlay;
}

fs::path FindResource(const std::string& kind, const std::string& name) {
  return IsResourcePath(name) ? fs::path(name) : FindResource(kind, name, ListResources(kind));
}

fs::path FindResource(const std::string& kind, const std::string& name,
                      const std::vector<std::string>& names) {
  if (IsResourcePath(name) || std::ranges::count(names, name) > 0) return PathOfResource(kind, name);
  throw ParameterError(fmt::format(
      "there is no '{}' in {}; did you mean '{}'? Choose one of {}, or give the path of a .yaml file",
      internal::Excerpt(name), kind, internal::NearestName(name, names), fmt::join(names, ", ")));
}

}  // namespace tenon
