// Runs that are stopped, and places that cannot be written: what is left is whole, and the exit code says
// why.

#include <tenon/tests/apps/run_app.h>

#include <algorithm>
#include <fstream>
#include <sstream>

namespace tenon::stopped_run_test {
namespace {

namespace fs = std::filesystem;
using test::Read;
using test::Result;
using test::RunCommand;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

const std::string kApp = TENON_QUADRUPED;

class TenonStoppedRunTest : public test::AppTest {
 protected:
  /// Runs for ever, until some rows are in the file; then `script`, in which $run is its process.
  Result WhileRunning(const std::string& script) const {
    fs::remove(out / "signals.csv");
    const std::string rows = "$(wc -l 2>/dev/null < " + (out / "signals.csv").string() + " || echo 0)";
    return RunCommand("bash -c '" + kApp + " flat --duration 100000" + Out() + " & run=$!; until [ " + rows +
                      " -gt 12 ]; do kill -0 $run || exit 99; sleep 0.02; done 2>/dev/null; " + script + "'");
  }
  enum class Last { kWhole, kMayBeTorn };
  /// All rows are as long as the header.
  void ExpectWholeRows(Last last = Last::kWhole) const {
    std::string text = Read(out / "signals.csv");
    ASSERT_FALSE(text.empty());
    if (last == Last::kMayBeTorn) text.erase(text.rfind('\n') + 1);
    EXPECT_TRUE(text.ends_with('\n'));
    std::istringstream file(text);
    std::string line;
    std::getline(file, line);
    const auto cells = std::count(line.begin(), line.end(), ',');
    int rows = 0;
    for (; std::getline(file, line); ++rows)
      ASSERT_EQ(std::count(line.begin(), line.end(), ','), cells) << rows;
    EXPECT_GT(rows, 10);
  }
};

TEST_F(TenonStoppedRunTest, ASignalEndsItInGoodOrder) {
  for (const auto& [signal, code] : {std::pair("INT", 130), std::pair("TERM", 143)}) {
    const Result result = WhileRunning("kill -" + std::string(signal) + " $run; wait $run");
    EXPECT_EQ(result.exit_code, code) << result.text;
    EXPECT_THAT(result.text, HasSubstr("com_error_max_m"));
    EXPECT_THAT(Read(out / "summary.json"),
                AllOf(HasSubstr("\"end_reason\": \"interrupted\""), HasSubstr("\"finished\": false"),
                      HasSubstr("\"fell\": false")));
    EXPECT_THAT(Read(out / "report.html"), HasSubstr("interrupted"));
    ExpectWholeRows();
  }
}

// The system ends a write between two pages when SIGKILL comes, so that the last row may be torn.
TEST_F(TenonStoppedRunTest, WhatIsKilledLeavesWholeRowsAndNothingOld) {
  fs::create_directories(out);
  std::ofstream(out / "report.html") << "of an earlier run";
  std::ofstream(out / "summary.json") << "of an earlier run";
  EXPECT_EQ(WhileRunning("kill -KILL $run; wait $run").exit_code, 137);
  ExpectWholeRows(Last::kMayBeTorn);
  EXPECT_FALSE(fs::exists(out / "report.html"));
  EXPECT_FALSE(fs::exists(out / "summary.json"));
  EXPECT_THAT(Read(out / "scenario.yaml"), HasSubstr("case: flat"));
}

TEST_F(TenonStoppedRunTest, NothingOutsideOfItsDirectoryGoes) {
  fs::create_directories(out / "run");
  std::ofstream(out / "report.html") << "of somebody else";
  std::ofstream(out / "run" / "summary.json") << R"({"..": {"end_reason": ""}})";
  EXPECT_EQ(RunCommand(kApp + " stand --duration 0.1 --out " + (out / "run").string()).exit_code, 0);
  EXPECT_EQ(Read(out / "report.html"), "of somebody else");
}

TEST_F(TenonStoppedRunTest, ADirectoryBelongsToOneRunAtATime) {
  const Result result =
      WhileRunning(kApp + " stand --duration 0.1" + Out() + "; echo second $?; kill -KILL $run; wait $run; " +
                   kApp + " stand --duration 0.1" + Out());
  EXPECT_THAT(result.text, AllOf(HasSubstr("another run writes into the output directory"),
                                 HasSubstr("choose another --out"), HasSubstr("second 2")));
  EXPECT_EQ(result.exit_code, 0) << "the lock dies with its process; " << result.text;
}

// A limit of the size of files stands for the end of a disk.
TEST_F(TenonStoppedRunTest, AFullDiskEndsItWithItsFigures) {
  const Result result = RunCommand("sh -c 'ulimit -f 200; " + kApp + " flat --duration 100000" + Out() + "'");
  EXPECT_EQ(result.exit_code, 5) << result.text;
  EXPECT_THAT(result.text, AllOf(HasSubstr("com_error_max_m"), HasSubstr("signals.csv': File too large"),
                                 HasSubstr("report.html': File too large")));
  EXPECT_THAT(Read(out / "summary.json"), HasSubstr("signals.csv': File too large"));
  ExpectWholeRows();
  for (const auto& entry : fs::directory_iterator(out))
    EXPECT_THAT(entry.path().string(), Not(HasSubstr(".part")));
}

// The run is over, and nothing is to be stopped: all files are there.
TEST_F(TenonStoppedRunTest, ASignalWhileTheResultsAreWrittenLosesNone) {
  for (const char* signal : {"INT", "TERM"}) {
    fs::remove_all(out);
    const Result result =
        RunCommand("bash -c '" + kApp + " flat --duration 10" + Out() + " & run=$!; until [ -e " +
                   (out / "summary.json").string() + " ]; do kill -0 $run || exit 99; done; kill -" + signal +
                   " $run; wait $run'");
    EXPECT_EQ(result.exit_code, 0) << result.text;
    EXPECT_THAT(result.text, HasSubstr("com_error_max_m"));
    EXPECT_TRUE(fs::exists(out / "report.html"));
  }
}

TEST_F(TenonStoppedRunTest, PlacesThatCannotBeWrittenAreExitCode5) {
  const Result directory = RunCommand(kApp + " stand --duration 0.1 --out /dev/full");
  EXPECT_EQ(directory.exit_code, 5);
  EXPECT_THAT(directory.text, HasSubstr("output directory '/dev/full'"));
  const Result figures = RunCommand("sh -c '" + kApp + " stand --duration 0.1" + Out() + " 2>&1 >/dev/full'");
  EXPECT_EQ(figures.exit_code, 5);
  EXPECT_THAT(figures.text, HasSubstr("cannot print the figures"));
  const Result comparison =
      RunCommand("sh -c '" + kApp + " A2 --compare --duration 0.1" + Out() + " 2>&1 >/dev/full'");
  EXPECT_EQ(comparison.exit_code, 5) << "more than one buffer of figures; " << comparison.text;
  const Result silent = RunCommand("sh -c '" + kApp + " stand --duration 0.1" + Out() + " 2>/dev/full'");
  EXPECT_EQ(silent.exit_code, 0) << "nobody need see the progress";
  const Result graph = RunCommand(kApp + " stand --duration 0.1" + Out() + " --graph /nonexistent/a.svg");
  EXPECT_EQ(graph.exit_code, 5);
  EXPECT_THAT(graph.text, HasSubstr("--graph /nonexistent/a.svg: cannot write"));
}

TEST_F(TenonStoppedRunTest, TheGraphIsDrawnWithoutAShell) {
  fs::create_directories(out);
  const fs::path crafted = out / "a\"; touch pwned; \".svg";
  const Result result = RunCommand("cd " + out.string() + " && " + kApp + " stand --duration 0.1" + Out() +
                                   " --graph '" + crafted.string() + "'");
  EXPECT_EQ(result.exit_code, 0) << result.text;
  EXPECT_THAT(Read(crafted), HasSubstr("<svg"));
  EXPECT_FALSE(fs::exists(out / "pwned"));
  const fs::path svg = out / "b.svg";
  for (int i = 0; i < 5; ++i) {
    const Result without = RunCommand("PATH=/nonexistent " + kApp + " stand --duration 0.1" + Out() +
                                      " --graph " + svg.string());
    EXPECT_EQ(without.exit_code, 2);
    EXPECT_THAT(without.text, HasSubstr("apt-get install graphviz"));
    EXPECT_FALSE(fs::exists(svg));
  }
}

TEST_F(TenonStoppedRunTest, AGraphThatCannotBeWrittenLeavesTheOneBefore) {
  fs::create_directories(out / "bin");
  std::ofstream(out / "bin" / "dot") << "#!/bin/sh\nexit 1\n";  // as at the end of a disk
  fs::permissions(out / "bin" / "dot", fs::perms::owner_all);
  std::ofstream(out / "graph.svg") << "of before";
  const Result result =
      RunCommand("PATH=" + (out / "bin").string() + ":$PATH " + kApp + " stand --duration 0.1" + Out() +
                 " --graph " + (out / "graph.svg").string());
  EXPECT_EQ(result.exit_code, 5);
  EXPECT_THAT(result.text,
              AllOf(HasSubstr("graph.svg': Graphviz's `dot` ended with 1"), HasSubstr("disk full")));
  EXPECT_EQ(Read(out / "graph.svg"), "of before");
  for (const auto& entry : fs::directory_iterator(out))
    EXPECT_THAT(entry.path().string(), Not(HasSubstr(".part")));
}

TEST_F(TenonStoppedRunTest, TextThatIsNotUtf8IsRefusedWhenRead) {
  fs::create_directories(out);
  std::ofstream(out / "own.yaml") << "extends: flat\ncase: caf\xe9\n";
  const Result scenario = RunCommand(kApp + " " + (out / "own.yaml").string() + Out());
  EXPECT_EQ(scenario.exit_code, 2);
  EXPECT_THAT(scenario.text, HasSubstr("own.yaml:2:10: byte 0xe9 is not UTF-8"));
  const Result argument = RunCommand(kApp + " flat --out '" + (out / "caf\xe9").string() + "'");
  EXPECT_EQ(argument.exit_code, 2);
  EXPECT_THAT(argument.text, HasSubstr("argument 3 of the command line"));
  fs::create_directories(out / "caf\xe9");
  const Result place = RunCommand("cd '" + (out / "caf\xe9").string() + "' && " + kApp + " flat");
  EXPECT_EQ(place.exit_code, 2);
  EXPECT_THAT(place.text, AllOf(HasSubstr("the working directory"), HasSubstr("caf\\xe9")));
}

}  // namespace
}  // namespace tenon::stopped_run_test
