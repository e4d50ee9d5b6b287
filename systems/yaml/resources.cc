#include <tenon/systems/framework/types/errors.h>
#include <tenon/systems/text/excerpt.h>
#include <tenon/systems/text/nearest_name.h>
#include <tenon/systems/yaml/resources.h>
#include <tenon/systems/yaml/yaml.h>

#include <dlfcn.h>
#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdlib>
#include <functional>

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
        fmt::format("there is no directory '{}': set TENON_DATA_DIR to the share/tenon of the installation",
                    directory.string()));
  }
  for (const auto& entry : fs::directory_iterator(directory)) {
    if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

std::vector<std::string> ListResources(const std::string& kind, const std::string& key) {
  std::vector<std::string> names = ListResources(kind);
  std::erase_if(names, [&](const std::string& name) {
    const std::vector<std::string> keys = YamlDocument::Load(FindResource(kind, name)).Keys("");
    return std::find(keys.begin(), keys.end(), key) == keys.end();
  });
  return names;
}

YamlDocument ResourceMap(const YamlFile& what) {
  const bool is_map = what.text.starts_with('{');
  return YamlDocument::Parse(is_map ? what.text : "file: " + what.text, kWhatDiffers);
}

std::string ResourceName(const YamlFile& what) {
  const YamlDocument map = ResourceMap(what);
  return map.Text("file") + (map.Keys("").size() > 1 ? ", changed" : "");
}

namespace {

YamlDocument Load(const YamlFile& what, const std::function<fs::path(const std::string& name)>& find) {
  YamlDocument overlay = ResourceMap(what);
  const std::string file = overlay.Text("file");
  if (file.empty())
    throw ParameterError("a map of what is different has to say in which file: {file: standard, …}");
  const YamlDocument whole = YamlDocument::Load(find(file));
  if (overlay.Keys("").size() == 1) return whole;
  overlay.Remove("file");
  overlay.AddMissing(whole);
  return overlay;
}

}  // namespace

YamlDocument LoadResource(const std::string& kind, const YamlFile& what) {
  return Load(what, [&](const std::string& name) { return FindResource(kind, name); });
}

YamlDocument LoadResource(const std::string& kind, const YamlFile& what, const std::string& key) {
  return Load(what, [&](const std::string& name) {
    const std::vector<std::string> all = ListResources(kind), fit = ListResources(kind, key);
    if (std::ranges::count(all, name) > 0 && std::ranges::count(fit, name) == 0)
      throw ParameterError(fmt::format("'{}' is of another kind, without '{}'; there are: {}", name, key,
                                       fmt::join(fit, ", ")));
    return FindResource(kind, name, fit);
  });
}

bool IsResourcePath(const std::string& name) {
  return name.ends_with(".yaml") || name.find('/') != std::string::npos;
}

fs::path FindResource(const std::string& kind, const std::string& name) {
  return IsResourcePath(name) ? fs::path(name) : FindResource(kind, name, ListResources(kind));
}

fs::path FindResource(const std::string& kind, const std::string& name,
                      const std::vector<std::string>& names) {
  if (IsResourcePath(name)) return name;
  if (std::find(names.begin(), names.end(), name) != names.end())
    return DataDirectory() / kind / (name + ".yaml");
  throw ParameterError(
      fmt::format("there is no '{}' in {}; did you mean '{}'? There are: {}. Or give a .yaml file",
                  internal::Excerpt(name), kind, internal::NearestName(name, names), fmt::join(names, ", ")));
}

}  // namespace tenon
