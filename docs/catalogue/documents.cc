#include <tenon/docs/catalogue/documents.h>
#include <tenon/docs/catalogue/page.h>
#include <tenon/systems/files/input_file.h>

#include <fmt/format.h>

#include <cstdint>
#include <cstdio>
#include <fstream>

namespace tenon::docs {
namespace {

namespace fs = std::filesystem;

/// The hash function FNV-1a of Fowler, Noll and Vo.
std::uint64_t Hash(const std::string& text) {
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const unsigned char c : text) hash = (hash ^ c) * 0x100000001b3;
  return hash;
}

fs::path FileOf(const Picture& picture, const fs::path& directory) {
  return directory / (picture.name + ".svg");
}

std::string LastLine(const Picture& picture) {
  return fmt::format("<!-- Drawn by tools/docs; hash of the diagram: {:016x} -->\n", Hash(picture.graphviz));
}

}  // namespace

std::string WriteBlocks(const fs::path& source) {
  return WritePage(ReadText(source / "docs/catalogue/blocks.md.in"), MakeCatalogue(), ReadHeaders(source));
}

void Draw(const Picture& picture, const fs::path& directory) {
  const fs::path file = FileOf(picture, directory);
  std::FILE* dot = popen(fmt::format("dot -Tsvg -o '{}'", file.string()).c_str(), "w");
  if (dot == nullptr || std::fputs(picture.graphviz.c_str(), dot) < 0 || pclose(dot) != 0) {
    throw Error(fmt::format("dot cannot draw {}: is Graphviz installed?", file.string()));
  }
  std::ofstream(file, std::ios::app) << LastLine(picture);
}

bool IsUpToDate(const Picture& picture, const fs::path& directory) {
  const fs::path file = FileOf(picture, directory);
  return fs::exists(file) && ReadText(file).ends_with(LastLine(picture));
}

}  // namespace tenon::docs
