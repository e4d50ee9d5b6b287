#include <tenon/apps/common/output_directory.h>
#include <tenon/systems/files/input_file.h>
#include <tenon/systems/files/output_file.h>

#include <fcntl.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <spawn.h>
#include <sys/file.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>

namespace tenon::apps {

namespace fs = std::filesystem;

OutputLock::OutputLock(fs::path path) : path_(std::move(path)) {
  std::error_code error;
  fs::create_directories(path_, error);
  lock_ = error ? -1 : ::open(path_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (lock_ < 0) {
    throw OutputError(fmt::format("cannot create the output directory '{}' ({}): choose another --out",
                                  path_.string(), error ? error.message() : std::strerror(errno)));
  }
  if (::flock(lock_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    ::close(lock_);
    throw ParameterError(
        fmt::format("another run writes into the output directory '{}': wait for it, or choose another --out",
                    path_.string()));
  }
}

OutputLock::~OutputLock() {
  ::close(lock_);
}

namespace {

/// Names of the variants that an earlier run left in a directory.
std::vector<std::string> VariantsIn(const fs::path& directory) {
  std::ifstream in = OpenInput(directory / "summary.json");
  const auto summary = nlohmann::json::parse(in, nullptr, false);
  std::vector<std::string> names;
  if (!summary.is_object()) return names;
  for (const auto& [name, figures] : summary.items())
    if (figures.is_object() && figures.contains("end_reason") && IsVariantName(name)) names.push_back(name);
  return names;
}

}  // namespace

bool IsVariantName(std::string_view name) {
  constexpr std::size_t kLongest = 200;  // [bytes]; file systems allow 255
  return !name.empty() && name.size() <= kLongest && name.front() != '.' &&
         name.find_first_of(std::string_view("/\0", 2)) == name.npos;
}

OutputDirectory::OutputDirectory(fs::path path) : OutputLock(std::move(path)) {
  std::error_code error;
  for (const std::string& variant : VariantsIn(this->path())) {
    const fs::path directory = this->path() / variant;
    if (!fs::is_directory(fs::symlink_status(directory, error))) continue;  // or a link to other files
    OutputDirectory{directory};
    fs::remove(directory, error);  // fails if it holds other files
  }
  std::vector<fs::path> left;
  for (const auto& entry : fs::directory_iterator(this->path(), error)) {
    const std::string file = entry.path().filename().string();
    for (const std::string name : {"scenario.yaml", "signals.csv", "summary.json", "report.html"})
      if (file == name || (file.starts_with("." + name + ".") && file.ends_with(".part")))  // of a killed run
        left.push_back(entry.path());
  }
  for (const fs::path& file : left) fs::remove(file, error);
}

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

std::optional<int> RunProgram(std::vector<std::string> arguments) {
  std::vector<char*> list;
  for (std::string& argument : arguments) list.push_back(argument.data());
  list.push_back(nullptr);
  ::pid_t process = 0;
  const int error = ::posix_spawnp(&process, list[0], nullptr, nullptr, list.data(), environ);
  if (error == ENOENT) return {};
  if (error != 0) throw OutputError(fmt::format("cannot run `{}`: {}", arguments[0], std::strerror(error)));
  int status = 0;
  while (::waitpid(process, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

}  // namespace tenon::apps
