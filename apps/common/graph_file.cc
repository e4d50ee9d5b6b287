#include <tenon/apps/common/graph_file.h>
#include <tenon/apps/common/run_program.h>
#include <tenon/systems/files/output_file.h>
#include <tenon/systems/framework/types/errors.h>

#include <fmt/format.h>
#include <unistd.h>

#include <optional>
#include <string>
#include <system_error>

namespace tenon::apps {

namespace fs = std::filesystem;

void WriteGraph(const Diagram& diagram, const fs::path& file) {
  if (file.empty()) return;
  if (file.extension() == ".dot") return WriteFile(file, diagram.Graphviz());
  if (file.extension() != ".svg") {
    throw ParameterError(fmt::format("--graph {}: name a file that ends in .svg or .dot", file.string()));
  }
  const fs::path svg = fs::absolute(file);
  const auto part = [&](const char* ending) {
    return fs::path(svg).replace_filename(
        fmt::format(".{}.{}{}.part", svg.filename().string(), ::getpid(), ending));
  };
  const fs::path text = part(".dot"), drawn = part("");
  try {
    WriteFile(text, diagram.Graphviz());
  } catch (const OutputError& failure) {
    throw OutputError(fmt::format("--graph {}: {}", file.string(), failure.what()));
  }
  const std::optional<int> code = RunProgram({"dot", "-Tsvg", "-o", drawn.string(), text.string()});
  std::error_code error, ignored;
  fs::remove(text, ignored);
  if (code == 0) fs::rename(drawn, svg, error);
  if (code != 0 || error) fs::remove(drawn, ignored);
  if (!code)
    throw ParameterError(fmt::format(
        "--graph {}: `dot` is not installed; apt-get install graphviz, or write a .dot file", file.string()));
  if (*code != 0)
    throw OutputError(fmt::format(
        "cannot write '{}': Graphviz's `dot` failed with exit code {}; free disk space, or write a .dot file",
        file.string(), *code));
  if (error) throw OutputError(fmt::format("cannot write '{}': {}", file.string(), error.message()));
}

}  // namespace tenon::apps
