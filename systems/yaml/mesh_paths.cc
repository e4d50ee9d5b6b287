#include <tenon/systems/files/input_file.h>
#include <tenon/systems/text/text.h>
#include <tenon/systems/yaml/mesh_paths.h>

#include <algorithm>
#include <sstream>

namespace tenon {

namespace fs = std::filesystem;

namespace {

/// Directories that may contain packages.
std::vector<fs::path> PackageFolders(const fs::path& urdf) {
  std::vector<fs::path> folders;
  for (fs::path at = fs::absolute(urdf).parent_path(); at != at.root_path(); at = at.parent_path())
    folders.push_back(at);
  const auto add = [&](const char* variable, const char* below) {
    const char* value = std::getenv(variable);
    std::stringstream list(value == nullptr ? "" : value);
    for (std::string folder; std::getline(list, folder, ':');)
      if (!folder.empty()) folders.push_back(fs::path(folder) / below);
  };
  add("ROS_PACKAGE_PATH", "");
  add("AMENT_PREFIX_PATH", "share");
  return folders;
}

/// The name of a ROS package in its package.xml, which may differ from that of its directory; empty if the
/// directory is no package.
std::string NameOfPackage(const fs::path& directory) {
  const std::string text = ReadText(directory / "package.xml");
  const std::size_t begin = text.find("<name>"), end = text.find("</name>");
  if (begin == text.npos || end == text.npos || end < begin) return "";
  return std::string(internal::Trimmed(std::string_view(text).substr(begin + 6, end - begin - 6)));
}

fs::path WithoutFirst(const fs::path& path) {
  fs::path rest;
  for (auto part = std::next(path.begin()); part != path.end(); ++part) rest /= *part;
  return rest;
}

}  // namespace

std::optional<fs::path> FindMesh(const std::string& name, const fs::path& urdf) {
  constexpr std::string_view kPackage = "package://", kFile = "file://", kFind = "file://$(find ";
  std::error_code error;
  if (name.find('\\') != name.npos) {  // written on Windows
    std::string slashes = name;
    std::ranges::replace(slashes, '\\', '/');
    return FindMesh(slashes, urdf);
  }
  if (const std::size_t end = name.find(')'); name.starts_with(kFind) && end != name.npos)
    return FindMesh(
        std::string(kPackage) + name.substr(kFind.size(), end - kFind.size()) + name.substr(end + 1), urdf);
  if (!name.starts_with(kPackage)) {
    const fs::path file = name.starts_with(kFile) ? fs::path(name.substr(kFile.size()))
                                                  : fs::absolute(urdf).parent_path() / name;
    if (fs::is_regular_file(file, error)) return file;
    return {};
  }
  const fs::path inside = fs::path(name.substr(kPackage.size())).relative_path();  // also of package:///PATH
  if (inside.empty()) return {};
  for (const fs::path& folder : PackageFolders(urdf)) {
    if (const fs::path file = folder / inside; fs::is_regular_file(file, error)) return file;
    if (const fs::path file = folder / WithoutFirst(inside);
        NameOfPackage(folder) == inside.begin()->string() && fs::is_regular_file(file, error))
      return file;
  }
  return {};
}

namespace {

constexpr std::pair<char, std::string_view> kEntities[] = {
    {'&', "&amp;"}, {'<', "&lt;"}, {'>', "&gt;"}, {'"', "&quot;"}, {'\'', "&apos;"}};

/// Escapes a text for use as the value of an attribute.
std::string ToXml(std::string_view text) {
  std::string xml;
  for (const char c : text) {
    const auto* entity = std::ranges::find(kEntities, c, &std::pair<char, std::string_view>::first);
    if (entity == std::end(kEntities)) {
      xml += c;
    } else {
      xml += entity->second;
    }
  }
  return xml;
}

std::string FromXml(std::string_view xml) {
  std::string text;
  while (!xml.empty()) {
    const auto* entity =
        std::ranges::find_if(kEntities, [&](const auto& each) { return xml.starts_with(each.second); });
    const bool is_one = entity != std::end(kEntities);
    text += is_one ? entity->first : xml.front();
    xml.remove_prefix(is_one ? entity->second.size() : 1);
  }
  return text;
}

}  // namespace

std::string WithMeshesFound(std::string text, const fs::path& urdf) {
  for (std::size_t at = text.find("<mesh"); at != std::string::npos; at = text.find("<mesh", at + 1)) {
    const std::size_t end = text.find('>', at), key = text.find("filename", at);
    if (end == std::string::npos || key > end) continue;
    const std::size_t open = text.find_first_of("\"'", key);
    if (open > end) continue;
    const std::size_t close = text.find(text[open], open + 1);
    if (close > end) continue;
    const std::string name = text.substr(open + 1, close - open - 1);
    if (const std::optional<fs::path> file = FindMesh(FromXml(name), urdf))
      text.replace(open + 1, name.size(), "file://" + ToXml(fs::weakly_canonical(*file).string()));
  }
  return text;
}

}  // namespace tenon
