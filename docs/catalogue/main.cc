// Writes what docs/ holds of the blocks and diagrams; tools/docs runs it.

#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>

#include <tenon/docs/catalogue/documents.h>

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fputs("usage: tenon-catalogue SOURCE_DIR OUT_DIR     writes blocks.md and diagrams/*.svg\n", stderr);
    return 2;
  }
  const std::filesystem::path source = argv[1], out = argv[2];
  try {
    std::filesystem::create_directories(out / "diagrams");
    std::ofstream(out / "blocks.md") << tenon::docs::WriteBlocks(source);
    for (const tenon::docs::Picture& picture : tenon::docs::MakePictures()) {
      if (!tenon::docs::IsUpToDate(picture, out / "diagrams")) tenon::docs::Draw(picture, out / "diagrams");
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "tenon-catalogue: %s\n", error.what());
    return 1;
  }
}
