#include <tenon/docs/catalogue/headers.h>

#include <fstream>
#include <regex>
#include <vector>

namespace tenon::docs {
namespace {

namespace fs = std::filesystem;
using Lines = std::vector<std::string>;

/// The first sentence of a docstring; it ends at the latest before a formula, a list or a table.
std::string FirstSentence(const Lines& docstring) {
  std::string text;
  for (const std::string& line : docstring) {
    if (line.empty() || line.starts_with("    ") || line.starts_with("|") || line.starts_with("- ")) break;
    if (line.starts_with("@file")) continue;
    text += (text.empty() ? "" : " ") + line;
  }
  static const std::regex kEnd(R"(\.\s+[A-Z`*])");
  std::smatch end;
  if (std::regex_search(text, end, kEnd)) text.resize(static_cast<std::size_t>(end.position()));
  const std::size_t last = text.find_last_not_of(".,:; ");
  if (last == std::string::npos) return "";
  return text.substr(0, last + 1) + ".";
}

/// Returns the docstring above line `i`, without its slashes.
Lines DocstringAbove(const Lines& lines, std::size_t i) {
  const auto belongs = [](const std::string& line) {
    return line.starts_with("template <") || line.starts_with("requires ");
  };
  while (i > 0 && belongs(lines[i - 1])) --i;
  std::size_t begin = i;
  while (begin > 0 && lines[begin - 1].starts_with("///")) --begin;
  Lines docstring;
  for (; begin < i; ++begin) docstring.push_back(lines[begin].substr(lines[begin].size() > 3 ? 4 : 3));
  return docstring;
}

}  // namespace

Lines ReadLines(const fs::path& file) {
  std::ifstream in(file);
  Lines lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

std::map<std::string, Declaration> ReadHeaders(const fs::path& source) {
  static const std::regex kType(
      R"((?:class|struct|enum class|enum|using) (\w+)( = .*|(?: final)?(?: :| \{|$).*))");
  static const std::regex kBlock(
      R"(class \w+(?: final)?\s*: public (?:LeafSystem<|Subdiagram\b|QuadrupedWalk\b|Block\b).*)");
  std::map<std::string, Declaration> found;
  for (const char* directory : {"systems", "plants", "controllers", "diagrams"}) {
    for (const auto& entry : fs::recursive_directory_iterator(source / directory)) {
      const std::string header = fs::relative(entry.path(), source).generic_string();
      if (entry.path().extension() != ".h" || header.find("/internal/") != std::string::npos) continue;
      if (std::regex_search(header, std::regex("/dds/|/unitree/|/mcap.h")))
        continue;  // optional, or needs a file
      const Lines lines = ReadLines(entry.path());
      for (std::size_t i = 0; i < lines.size(); ++i) {
        std::smatch match;
        if (!std::regex_match(lines[i], match, kType)) continue;
        // A long declaration continues in the next line.
        const std::string declaration = lines[i] + (i + 1 < lines.size() ? lines[i + 1] : "");
        found.try_emplace(match[1], Declaration{header, FirstSentence(DocstringAbove(lines, i)),
                                                std::regex_match(declaration, kBlock)});
      }
    }
  }
  return found;
}

}  // namespace tenon::docs
