#include <tenon/apps/campaign/campaign_runner.h>
#include <tenon/systems/files/input_file.h>

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>

namespace tenon::apps {

namespace fs = std::filesystem;

namespace {

/// A temporary directory, removed with the object.
class Scratch {
 public:
  Scratch() {
    std::string name = (fs::temp_directory_path() / "tenon-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr)
      throw OutputError(fmt::format("cannot create a directory in '{}': set TMPDIR to a writable directory",
                                    fs::temp_directory_path().string()));
    path_ = name;
  }
  ~Scratch() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

/// The end of a process.
struct Ended {
  int code = 0;           ///< exit code, 128 plus the signal as in a shell
  bool too_long = false;  ///< it exceeded the limit of wall-clock time

  /// Returns whether something outside ended the process: a user or the system by a signal, a full disk, or
  /// the lack of a program.
  bool by_machine() const {
    constexpr std::array<int, 7> kCodes{kOutputFailed, 126,           127,          128 + SIGHUP,
                                        128 + SIGINT,  128 + SIGKILL, 128 + SIGTERM};
    return !too_long && SignalGuard::caught() == 0 && std::ranges::find(kCodes, code) != kCodes.end();
  }
};

using Clock = std::chrono::steady_clock;
constexpr std::chrono::milliseconds kLook{5};  // polling interval
constexpr std::chrono::seconds kGrace{5};      // time to write files after SIGTERM

/// Returns the exit code of a process once it has ended.
std::optional<int> CodeOf(::pid_t process) {
  int status = 0;
  const ::pid_t waited = ::waitpid(process, &status, WNOHANG);
  if (waited < 0 && errno != EINTR) throw RunError("lost the process of a run");
  if (waited != process) return {};
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

/// Ends the group of a process by SIGTERM and, if it does not react, by SIGKILL.
int End(::pid_t process) {
  ::kill(-process, SIGTERM);
  std::optional<int> code;
  for (const Clock::time_point deadline = Clock::now() + kGrace; Clock::now() < deadline;
       std::this_thread::sleep_for(kLook)) {
    if (!code) code = CodeOf(process);
    if (code && ::kill(-process, 0) != 0) return *code;
  }
  ::kill(-process, SIGKILL);
  while (!code) {
    std::this_thread::sleep_for(kLook);
    code = CodeOf(process);
  }
  return *code;
}

/// Waits for a process and forwards received signals to it. Ends it at the limit of wall-clock time [s].
Ended Wait(::pid_t process, std::optional<double> wall_limit) {
  const Clock::time_point begin = Clock::now();
  for (int told = 0;; std::this_thread::sleep_for(kLook)) {
    if (const auto code = CodeOf(process)) return {*code, false};
    const std::chrono::duration<double> elapsed = Clock::now() - begin;
    const int signal = SignalGuard::caught();
    if (signal == 0 && wall_limit && elapsed.count() > *wall_limit) return {End(process), true};
    if (signal == told) continue;
    ::kill(-process, signal);
    told = signal;
  }
}

/// Runs a program with its output redirected to the file `printed`. The program has its own process group, so
/// that it receives Ctrl-C once from Wait and not also from the terminal: a second signal would end it at
/// once. It ends if this process is killed.
Ended Execute(const fs::path& program, const std::vector<std::string>& arguments, const fs::path& printed,
              std::optional<double> wall_limit = {}) {
  std::vector<std::string> texts{program.string()};
  texts.insert(texts.end(), arguments.begin(), arguments.end());
  std::vector<char*> list;
  for (std::string& text : texts) list.push_back(text.data());
  list.push_back(nullptr);
  const int output = ::open(printed.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  if (output < 0)
    throw OutputError(
        fmt::format("cannot write '{}': {}", printed.string(), std::generic_category().message(errno)));
  std::array<int, 2> report{};  // a pipe that exec closes, or that carries its error
  if (::pipe2(report.data(), O_CLOEXEC) != 0) {
    ::close(output);
    throw OutputError("cannot open a pipe to a program: too many files are open");
  }
  const ::pid_t self = ::getpid(), process = ::fork();
  if (process == 0) {  // only calls that are safe after the fork of a process with threads
    ::setpgid(0, 0);
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::getppid() == self && ::dup2(output, STDOUT_FILENO) >= 0 && ::dup2(output, STDERR_FILENO) >= 0)
      ::execv(program.c_str(), list.data());
    const int error = errno;
    [[maybe_unused]] const ::ssize_t written = ::write(report[1], &error, sizeof(error));
    ::_exit(127);
  }
  const int no_fork = process < 0 ? errno : 0;
  ::close(output);
  ::close(report[1]);
  int error = no_fork;
  if (process > 0) {
    ::setpgid(process, process);  // also here, because Wait may send a signal to the group at once
    while (::read(report[0], &error, sizeof(error)) < 0 && errno == EINTR) {
    }
  }
  ::close(report[0]);
  if (error != 0) {
    if (process > 0) ::waitpid(process, nullptr, 0);
    throw OutputError(
        fmt::format("cannot run '{}': {}", program.string(), std::generic_category().message(error)));
  }
  return Wait(process, wall_limit);
}

/// Returns the end of a program's output, which usually gives the reason of its end.
std::string EndOf(std::string text) {
  constexpr std::size_t kMost = 1000;  // [bytes]
  if (text.size() <= kMost) return text;
  text.erase(0, text.size() - kMost);
  const auto within = [](char c) { return (static_cast<unsigned char>(c) & 0xc0) == 0x80; };  // in UTF-8
  return "…" + std::string(std::ranges::find_if_not(text, within), text.end());
}

/// Returns a text without the path of a temporary directory, which differs in each run.
std::string Without(const Scratch& scratch, std::string text) {
  const std::string path = scratch.path().string() + "/";
  for (std::size_t at; (at = text.find(path)) != text.npos;) text.erase(at, path.size());
  return text;
}

/// Throws OutputError if the disk of the temporary directory is full, which is then the reason of a failure.
void DemandSpace(const Scratch& scratch, const std::string& failure) {
  constexpr std::uintmax_t kLeast = 1 << 16;  // [bytes]
  std::error_code error;
  if (const fs::space_info space = fs::space(scratch.path(), error); !error && space.available < kLeast)
    throw OutputError(fmt::format("the disk of '{}' is full: set TMPDIR to a directory on another one ({})",
                                  scratch.path().parent_path().string(), failure));
}

/// Writes the scenario with absolute paths to a file and returns its path.
std::string Written(const YamlDocument& scenario, const Scratch& scratch) {
  const fs::path file = scratch.path() / "scenario.yaml";
  WriteFile(file, scenario.WithAbsolutePaths().Flow() + "\n");
  return file.string();
}

}  // namespace

ScenarioApp ProgramApp(const fs::path& program) {
  if (::access(program.c_str(), X_OK) != 0 || fs::is_directory(program))
    throw ParameterError(
        fmt::format("cannot run '{}': check the path and build the program", program.string()));
  const auto check = [program](const YamlDocument& scenario) {
    const Scratch scratch;
    const fs::path printed = scratch.path() / "printed";
    const Ended ended = Execute(program, {Written(scenario, scratch), "--keys"}, printed);
    if (ended.by_machine()) throw OutputError(Without(scratch, EndOf(ReadText(printed))));
    if (ended.code != kRan) throw ParameterError(Without(scratch, ReadText(printed)));
  };
  const auto run = [program](const YamlDocument& scenario, std::optional<double> duration,
                             const RunOptions& options) -> RunResult {
    const Scratch scratch;
    const fs::path out = options.out.empty() ? scratch.path() / "out" : options.out;
    const fs::path printed = scratch.path() / "printed";
    std::vector<std::string> arguments{Written(scenario, scratch), "--out", out.string()};
    if (duration) arguments.insert(arguments.end(), {"--duration", fmt::format("{}", *duration)});
    std::error_code ignored;
    fs::remove(out / "summary.json", ignored);  // of an earlier run
    const Ended ended = Execute(program, arguments, printed, options.wall_limit);
    const auto reason = [&] {
      return ended.too_long ? TookTooLong(*options.wall_limit)
                            : fmt::format("{} ended with {}: {}", program.filename().string(), ended.code,
                                          EndOf(Without(scratch, ReadText(printed))));
    };
    if (ended.by_machine()) throw OutputError(reason());
    if (ended.code != kRan) DemandSpace(scratch, reason());
    if (!fs::exists(out / "summary.json")) throw RunError(reason());
    RunResult result = [&] {
      try {
        return RunResult{Summary::Load(out / "summary.json", ended.code), std::nullopt};
      } catch (const RunError& error) {
        DemandSpace(scratch, error.what());
        throw RunError(Without(scratch, error.what()));
      }
    }();
    if (ended.too_long && ended.code != kOutputFailed) {
      result.summary.EndedBy(reason(), kNumericalFailure);
    } else if (ended.code != kRan && result.summary.finished()) {
      result.summary.EndedBy(reason(), ended.code);  // a run survives only with exit code 0
    }
    return result;
  };
  return {.name = {}, .description = {}, .keys = {}, .check = check, .run = run};
}

}  // namespace tenon::apps
