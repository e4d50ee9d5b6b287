#pragma once

#include <tenon/tests/testing/temporary_path.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace tenon::test {

struct Result {
  int exit_code;     // 128 and the signal's number of what a signal ended, as in a shell
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

/// The whole file, or nothing of one that is not there.
inline std::string Read(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

/// A column of signals.csv by its name in the first row.
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

/// A test that runs an app. What the app writes to `out` goes with the test.
class AppTest : public ::testing::Test {
 protected:
  ~AppTest() override { std::filesystem::remove_all(out); }
  std::string Out() const { return " --out " + out.string(); }

  const std::filesystem::path out = [] {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    return TemporaryPath("tenon_" + std::string(test->test_suite_name()) + "_" + test->name());
  }();
};

struct BadUsage {
  const char* arguments;
  const char* message;
  friend void PrintTo(const BadUsage& usage, std::ostream* out) { *out << "'" << usage.arguments << "'"; }
};

/// A test that an app refuses its arguments.
class UsageTest : public AppTest, public ::testing::WithParamInterface<BadUsage> {
 protected:
  void ExpectExitCode2WithItsMessage(const std::string& app) const {
    const Result result = RunCommand(app + " " + GetParam().arguments + Out());
    EXPECT_EQ(result.exit_code, 2) << result.text;
    EXPECT_THAT(result.text, ::testing::HasSubstr(GetParam().message));
  }
};

}  // namespace tenon::test
