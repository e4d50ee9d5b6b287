#include <tenon/apps/common/graph_file.h>
#include <tenon/systems/files/output_file.h>
#include <tenon/systems/framework/types/errors.h>

#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <optional>
#include <string>
#include <system_error>

namespace tenon::apps {

namespace fs = std::filesystem;

namespace {

/// Runs Graphviz's `dot` without a shell. Returns its exit code, or nothing if `dot` is not installed.
std::optional<int> RunDot(const fs::path& text, const fs::path& svg) {
  std::string arguments[] = {"dot", "-Tsvg", "-o", svg.string(), text.string()};
  char* list[] = {arguments[0].data(), arguments[1].data(), arguments[2].data(),
                  arguments[3].data(), arguments[4].data(), nullptr};
  ::pid_t process = 0;
  const int error = ::posix_spawnp(&process, "dot", nullptr, nullptr, list, environ);
  if (error == ENOENT) return {};
  if (error != 0) throw OutputError(fmt::format("cannot run Graphviz's `dot`: {}", std::strerror(error)));
  int status = 0;
  while (::waitpid(process, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

}  // namespace

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
  const std::optional<int> code = RunDot(text, drawn);
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
