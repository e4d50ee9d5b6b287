#pragma once

#include <tenon/tests/testing/matchers.h>
#include <tenon/tests/testing/temporary_path.h>

#include <sys/wait.h>

#include <cstdio>
#include <stdexcept>
#include <utility>
#include <vector>

namespace tenon::test {

struct Result {
  int exit_code;     // 128 plus the number of the signal that ended the command, as in a shell
  std::string text;  // stdout and stderr
};

inline Result RunCommand(const std::string& command) {
  std::FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  if (pipe == nullptr) throw std::runtime_error("cannot run '" + command + "'");
  std::string text;
  char buffer[4096];
  for (std::size_t n; (n = std::fread(buffer, 1, sizeof(buffer), pipe)) > 0;) text.append(buffer, n);
  const int status = pclose(pipe);
  return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), text};
}

/// The column of signals.csv with this name in the first row.
inline std::vector<double> Column(const std::filesystem::path& out, const std::string& name) {
  std::ifstream file(out / "signals.csv");
  std::string line, cell;
  std::getline(file, line);
  std::istringstream header(line);
  int column = 0;
  while (std::getline(header, cell, ',') && cell != name) ++column;
  EXPECT_EQ(cell, name);
  std::vector<double> values;
  while (std::getline(file, line)) {
    std::istringstream row(line);
    for (int i = 0; i <= column; ++i) std::getline(row, cell, ',');
    values.push_back(std::stod(cell));
  }
  return values;
}

/// A test that runs an app as its users do. The app writes to the directory `out`, which is removed
/// afterwards.
struct AppTest : ::testing::Test {
  explicit AppTest(std::string app = "") : app(std::move(app)) {}
  ~AppTest() override { std::filesystem::remove_all(out); }

  std::string Out() const { return " --out " + out.string(); }
  /// Runs the app with --out, expects the exit code, and returns what it printed.
  std::string Run(const std::string& arguments, int exit_code = 0) const {
    const Result result = RunCommand(app + " " + arguments + Out());
    EXPECT_EQ(result.exit_code, exit_code) << arguments << ": " << result.text;
    return result.text;
  }
  std::string Summary() const { return ReadText(out / "summary.json"); }
  std::string Signals() const { return ReadText(out / "signals.csv"); }
  /// Writes a file in `out` and returns its path.
  std::string Write(const std::string& name, const std::string& text) const {
    std::filesystem::create_directories((out / name).parent_path());
    std::ofstream(out / name) << text;
    return (out / name).string();
  }

  /// Arguments that the app refuses, and the argument, key, file or line that its message names.
  struct BadUsage {
    std::string arguments, place;
  };
  void ExpectRefused(const std::vector<BadUsage>& usages) const {
    for (const auto& [arguments, place] : usages)
      EXPECT_THAT(Run(arguments, 2), ::testing::HasSubstr(place)) << arguments;
  }
  /// Expects that the app refuses each of the settings KEY=VALUE of a scenario and names its key, or an
  /// element of its value.
  void ExpectSettingsRefused(const std::string& scenario, const std::vector<std::string>& settings) const {
    for (const std::string& setting : settings) {
      const std::string key = setting.substr(0, setting.find('='));
      const std::string place = "--set " + setting + ": " + key;
      EXPECT_THAT(Run(scenario + " --set '" + setting + "'", 2),
                  ::testing::AnyOf(::testing::HasSubstr(place + ": "), ::testing::HasSubstr(place + ".")));
    }
  }

  const std::string app;
  const std::filesystem::path out = [] {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    return TemporaryPath("tenon_" + std::string(test->test_suite_name()) + "_" + test->name());
  }();
};

}  // namespace tenon::test
