// Writes blocks.md, scenarios.md, keys/meanings.yaml and diagrams/*.svg of docs/; run by tools/docs.

#include <tenon/docs/catalogue/documents.h>
#include <tenon/docs/catalogue/scenario_page.h>

#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fputs("usage: tenon-catalogue SOURCE_DIR OUT_DIR\n", stderr);
    return 2;
  }
  const std::filesystem::path source = argv[1], out = argv[2];
  try {
    std::filesystem::create_directories(out / "diagrams");
    std::filesystem::create_directories(out / "keys");
    std::ofstream(out / "keys" / "meanings.yaml") << tenon::docs::WriteMeanings(source);
    std::ofstream(out / "scenarios.md") << tenon::docs::WriteScenarioKeys();
    std::ofstream(out / "blocks.md") << tenon::docs::WriteBlocks(source);
    for (const tenon::docs::Picture& picture : tenon::docs::MakePictures()) {
      if (!tenon::docs::IsUpToDate(picture, out / "diagrams")) tenon::docs::Draw(picture, out / "diagrams");
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "tenon-catalogue: %s\n", error.what());
    return 1;
  }
}
