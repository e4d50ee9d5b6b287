#include <tenon/plants/model/resources.h>

#include <dlfcn.h>
#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdlib>

#include <tenon/systems/framework/errors.h>
#include <tenon/systems/framework/internal/excerpt.h>
#include <tenon/systems/framework/internal/nearest_name.h>
#include <tenon/systems/yaml/yaml.h>

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

YamlDocument LoadResource(const std::string& kind, const YamlText& what) {
  YamlDocument overlay = YamlDocument::Parse("of: " + what.text, kind);
  if (overlay.Keys("of").empty()) return YamlDocument::Load(FindResource(kind, overlay.Text("of")));
  overlay = YamlDocument::Parse(what.text, kind);
  const std::string file = overlay.Text("file");
  if (file.empty())
    throw ParameterError("a map of what is different has to say in which file: {file: standard, …}");
  overlay.Remove("file");
  overlay.AddMissing(YamlDocument::Load(FindResource(kind, file)));
  return overlay;
}

fs::path FindResource(const std::string& kind, const std::string& name) {
  if (name.ends_with(".yaml") || name.find('/') != std::string::npos) return name;
  const std::vector<std::string> names = ListResources(kind);
  if (std::find(names.begin(), names.end(), name) != names.end())
    return DataDirectory() / kind / (name + ".yaml");
  throw ParameterError(
      fmt::format("there is no '{}' in {}; did you mean '{}'? There are: {}. Or give a .yaml file",
                  internal::Excerpt(name), kind, internal::NearestName(name, names), fmt::join(names, ", ")));
}

}  // namespace tenon
