#include <tenon/apps/campaign/campaign_file.h>
#include <tenon/apps/cdpr/cdpr_scenario.h>
#include <tenon/apps/common/scenario_keys.h>
#include <tenon/apps/guide_dog/guide_dog_scenario.h>
#include <tenon/apps/quadruped/quadruped_scenario.h>
#include <tenon/docs/catalogue/headers.h>
#include <tenon/docs/catalogue/scenario_page.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <string_view>
#include <utility>
#include <vector>

namespace tenon::docs {
namespace {

namespace fs = std::filesystem;
using apps::ScenarioKey;

/// The docstrings of one struct and of its members, and the key of each member.
struct Members {
  std::string about;                             ///< docstring of the struct
  std::map<std::string, std::string> meanings;   ///< docstring by member
  std::vector<std::array<std::string, 4>> keys;  ///< key, member; struct and name of its member
};

/// Returns the docstring that follows `slashes` in a line, or an empty string.
std::string Docstring(const std::string& line, const std::string& slashes) {
  const std::size_t at = line.find(slashes);
  if (at == line.npos || (slashes == "/// " && line.find_first_not_of(' ') != at)) return "";
  return line.substr(at + slashes.size());
}

std::string Joined(const std::string& text, const std::string& more) {
  return text.empty() || more.empty() ? text + more : text + " " + more;
}

void ReadStructs(const fs::path& file, std::map<std::string, Members>& found) {
  static const std::regex kStruct(R"(^ *struct (\w+)(?: final)?(?: : [^;{]*)? \{.*)");
  static const std::regex kName(R"((\w+)\s*(?:=|\{|,|;))");
  std::string name, above, declaration;
  bool trailing = false;  // whether the next line may continue a trailing docstring
  std::vector<std::string> declared;
  for (const std::string& line : ReadLines(file)) {
    std::smatch match;
    if (std::regex_match(line, match, kStruct)) {
      name = match[1];
      found[name].about = std::exchange(above, {});
      continue;
    }
    if (const std::string text = Docstring(line, "/// "); !text.empty()) {
      above = Joined(above, text);
      trailing = false;
      continue;
    }
    Members& members = found[name];
    const std::size_t code = line.find_first_not_of(' ');
    const bool only_docstring = code != line.npos && line.compare(code, 4, "///<") == 0;
    if (only_docstring) {
      if (trailing)
        for (const std::string& member : declared)
          members.meanings[member] = Joined(members.meanings[member], Docstring(line, "///< "));
      continue;
    }
    trailing = false;
    const std::string text = line.substr(0, line.find("///<"));
    declaration += text + " ";
    const std::string trimmed = text.substr(0, text.find_last_not_of(' ') + 1);
    const bool ends = trimmed.ends_with(';');
    if (!ends && !trimmed.empty() && !trimmed.ends_with(" {") && !trimmed.ends_with('}')) continue;
    // The declaration is complete.
    declared.clear();
    const std::size_t initial = declaration.find_first_of("({=");  // a function has a bracket before its body
    if (ends && (initial == declaration.npos || declaration[initial] != '(')) {
      const std::string doc = Joined(above, Docstring(line, "///< "));
      for (auto it = std::sregex_iterator(declaration.begin(), declaration.end(), kName);
           it != std::sregex_iterator(); ++it) {
        declared.push_back((*it)[1]);
        members.meanings.emplace((*it)[1], doc);
      }
      trailing = true;
    }
    above.clear();
    declaration.clear();
  }
}

/// Reads the key of each member from the definitions of Fields() in a file.
void ReadKeys(const fs::path& file, std::map<std::string, Members>& found) {
  static const std::regex kBegin(
      R"(struct (\w+)(?: final)?(?: :[^;{]*)? \{|FieldList (?:(\w+)::)?(?:Fields|With)\([^)]*\) \{)");
  static const std::regex kKey(
      R"re((?:\{|Field\(|Required\()"(\w+)",\s*&(?:\w+::)*(\w+)(?:,\s*&(\w+)::(\w+))?)re");
  std::string text, name;
  for (const std::string& line : ReadLines(file)) text += line + '\n';
  for (auto it = std::sregex_iterator(text.begin(), text.end(), kBegin); it != std::sregex_iterator(); ++it) {
    const std::smatch& begin = *it;
    if (begin[1].matched) {
      name = begin[1];
      continue;
    }
    const auto from = static_cast<std::size_t>(begin.position());
    std::size_t end = text.find("};", from);
    while (end != text.npos && text[end - 1] == ' ') end = text.find("};", end + 1);  // of a lambda
    const std::string list = text.substr(from, end - from);
    for (auto key = std::sregex_iterator(list.begin(), list.end(), kKey); key != std::sregex_iterator();
         ++key)
      found[begin[2].matched ? begin[2].str() : name].keys.push_back(
          {(*key)[1], (*key)[2], (*key)[3], (*key)[4]});
  }
}

/// Removes the unit at the end of a meaning; the key already contains it.
std::string WithoutUnit(const std::string& meaning) {
  static const std::regex kUnit(R"( ?\[[^\]]*\]$)");
  return std::regex_replace(meaning, kUnit, "");
}

/// Adds the names of all structs that a type contains, including its own.
void AddStructs(const internal::TypeInfo& type, std::set<std::string>& names) {
  if (type.kind == internal::TypeInfo::Kind::kStruct)
    names.insert(apps::StructName(*type.id));
  else if (type.item != nullptr)
    AddStructs(type.item(), names);
  for (const Field& field : type.fields) {
    names.insert(apps::StructName(*field.owner));
    AddStructs(field.type(), names);
  }
}

struct Page {
  const char* app;
  const char* what;
  const internal::TypeInfo& (*type)();
  std::vector<ScenarioKey> (*keys)();
};

const Page kPages[] = {
    {"tenon-cdpr", "the cable robot", &internal::TypeInfoOf<apps::CdprScenario>,
     &apps::KeysOf<apps::CdprScenario>},
    {"Cable robots", "the file of a cable robot, see [cable_robots.md](cable_robots.md)",
     &internal::TypeInfoOf<CdprDescription>, &apps::KeysOf<CdprDescription>},
    {"tenon-quadruped", "the quadruped; tenon-gait-stability has the same keys",
     &internal::TypeInfoOf<apps::QuadrupedScenario>, &apps::KeysOf<apps::QuadrupedScenario>},
    {"tenon-guide-dog", "the quadruped with a person on a leash",
     &internal::TypeInfoOf<apps::GuideDogScenario>, &apps::KeysOf<apps::GuideDogScenario>},
    {"tenon-campaign", "a campaign file, see [campaigns.md](campaigns.md)",
     &internal::TypeInfoOf<apps::CampaignFile>, &apps::KeysOf<apps::CampaignFile>},
};

/// Puts a backslash before each character of `text` that is in `which`.
std::string Escaped(const std::string& text, std::string_view which) {
  std::string escaped;
  for (const char c : text) {
    if (which.find(c) != which.npos) escaped += '\\';
    escaped += c;
  }
  return escaped;
}

constexpr const char* kHead = R"(# All keys of scenarios

<!-- Written by tools/docs --blocks from the apps themselves. -->

This page lists the keys that a scenario's YAML file or `--set KEY=VALUE` can set; each app prints its own keys with `--keys`. Empty
brackets stand for the index of a list item: `forces[].start_s` is the start time of any force, and `--set forces.0.start_s=2` sets the
start time of the first one.

- A value of type **file** is the name of a shipped file, a path, or a map of values that differ from a file,
  `robot: {file: cdpr_4, mass_kg: 6}`. The option `--set robot.mass_kg=6` turns `robot: cdpr_4` into the same map. A path ends in
  `.yaml`. It is relative to the file that contains it, or to the working directory on the command line.
- `extends: NAME` takes all values that this scenario does not set from another scenario, shipped or a file. `format: 1` is the version
  of the file format and is optional.
- A number can be random, `{uniform: [low, high]}`, see [campaigns.md](campaigns.md).
- The scenario.yaml of a run contains every key, of `sensors` those that were given. Files that the run needs and that do not ship with Tenon are copied to `files` beside
  it, so the run can be repeated after the directory has been moved.
)";

}  // namespace

std::string WriteMeanings(const fs::path& source) {
  std::map<std::string, Members> found{{"", {}}};
  std::vector<fs::path> files;
  for (const char* directory : {"systems", "plants", "controllers", "diagrams", "apps"})
    for (const auto& entry : fs::recursive_directory_iterator(source / directory))
      if (entry.path().extension() == ".h" || entry.path().extension() == ".cc")
        files.push_back(entry.path());
  std::ranges::sort(files, {}, [](const fs::path& file) {  // headers first: they have the docstrings
    return std::pair(file.extension() != ".h", file);
  });
  for (const fs::path& file : files) {
    ReadStructs(file, found);
    ReadKeys(file, found);
  }
  std::set<std::string> names{"AppScenario"};
  for (const Page& page : kPages) AddStructs(page.type(), names);

  std::string text =
      "# What the keys of scenarios mean; written by tools/docs --blocks from the docstrings.\nstructs:\n";
  const auto quoted = [](const std::string& meaning) { return '"' + Escaped(meaning, "\"\\") + '"'; };
  for (const std::string& name : names) {
    Members& members = found[name];
    std::string lines;
    for (const auto& [key, member, part, part_member] : members.keys) {
      std::string meaning = WithoutUnit(members.meanings[member]);
      if (!part.empty())
        meaning += (meaning.empty() ? "" : ": ") + WithoutUnit(found[part].meanings[part_member]);
      if (!meaning.empty()) lines += fmt::format("    {}: {}\n", key, quoted(meaning));
    }
    if (!members.about.empty()) lines += fmt::format("    about: {}\n", quoted(members.about));
    if (!lines.empty()) text += fmt::format("  {}:\n{}", name, lines);
  }
  return text;
}

std::string WriteScenarioKeys() {
  std::string text = kHead;
  for (const Page& page : kPages) {
    text += fmt::format("\n## {}\n\nKeys of {}.\n\n", page.app, page.what);
    text += "| key | type | unit | range | default | meaning |\n| --- | --- | --- | --- | --- | --- |\n";
    for (const ScenarioKey& key : page.keys())
      text += fmt::format("| `{}` | {} | {} | {} | {} | {} |\n", key.key, key.type, key.unit, key.range,
                          key.initial.empty() ? "" : "`" + key.initial + "`", Escaped(key.meaning, "|"));
  }
  return text;
}

}  // namespace tenon::docs
