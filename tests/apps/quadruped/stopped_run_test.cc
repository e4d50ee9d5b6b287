// Runs that are stopped, and places that cannot be written: all files that remain are complete, and the exit
// code says why.

#include <tenon/tests/apps/run_app.h>

namespace tenon::stopped_run_test {

namespace fs = std::filesystem;
using test::Result, test::RunCommand, ::testing::HasSubstr, ::testing::Not;

class TenonStoppedRunTest : public test::AppTest {
 protected:
  TenonStoppedRunTest() : AppTest(TENON_QUADRUPED) {}
  /// Starts an endless run, waits for some rows in its file and runs `script`, in which $run is its process.
  Result WhileRunning(const std::string& script) const {
    fs::remove(out / "signals.csv");
    const std::string rows = "$(wc -l 2>/dev/null < " + (out / "signals.csv").string() + " || echo 0)";
    return RunCommand("bash -c '" + app + " flat --duration 100000" + Out() + " & run=$!; until [ " + rows +
                      " -gt 12 ]; do kill -0 $run || exit 99; sleep 0.02; done 2>/dev/null; " + script + "'");
  }
  enum class Last { kWhole, kMayBeTorn };
  /// Expects that all rows have as many cells as the header.
  void ExpectWholeRows(Last last = Last::kWhole) const {
    std::string text = Signals();
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
    EXPECT_THAT(Summary(),
                HasSubstrs("\"end_reason\": \"interrupted\"", "\"finished\": false", "\"fell\": false"));
    EXPECT_THAT(ReadText(out / "report.html"), HasSubstr("interrupted"));
    ExpectWholeRows();
  }
}

// SIGKILL can end a write between two pages, so the last row may be incomplete.
TEST_F(TenonStoppedRunTest, AKilledRunLeavesWholeRowsAndNoOldFiles) {
  Write("report.html", "of an earlier run");
  Write("summary.json", "of an earlier run");
  EXPECT_EQ(WhileRunning("kill -KILL $run; wait $run").exit_code, 137);
  ExpectWholeRows(Last::kMayBeTorn);
  EXPECT_FALSE(fs::exists(out / "report.html"));
  EXPECT_FALSE(fs::exists(out / "summary.json"));
  EXPECT_THAT(ReadText(out / "scenario.yaml"), HasSubstr("case: flat"));
}

TEST_F(TenonStoppedRunTest, NothingOutsideOfItsDirectoryGoes) {
  Write("report.html", "of somebody else");
  Write("run/summary.json", R"({"..": {"end_reason": ""}})");
  EXPECT_EQ(RunCommand(app + " stand --duration 0.1 --out " + (out / "run").string()).exit_code, 0);
  EXPECT_EQ(ReadText(out / "report.html"), "of somebody else");
}

TEST_F(TenonStoppedRunTest, ADirectoryBelongsToOneRunAtATime) {
  const Result result =
      WhileRunning(app + " stand --duration 0.1" + Out() + "; echo second $?; kill -KILL $run; wait $run; " +
                   app + " stand --duration 0.1" + Out());
  EXPECT_THAT(result.text,
              HasSubstrs("another run writes into the output directory", "choose another --out", "second 2"));
  EXPECT_EQ(result.exit_code, 0) << "the lock dies with its process; " << result.text;
}

// A limit of the file size stands for a full disk.
TEST_F(TenonStoppedRunTest, AFullDiskEndsItWithItsFigures) {
  const Result result = RunCommand("sh -c 'ulimit -f 200; " + app + " flat --duration 100000" + Out() + "'");
  EXPECT_EQ(result.exit_code, 5) << result.text;
  EXPECT_THAT(result.text,
              HasSubstrs("com_error_max_m", "signals.csv': File too large", "report.html': File too large"));
  EXPECT_THAT(Summary(), HasSubstr("signals.csv': File too large"));
  ExpectWholeRows();
  for (const auto& entry : fs::directory_iterator(out))
    EXPECT_THAT(entry.path().string(), Not(HasSubstr(".part")));
}

// The run has ended when the signal comes, so all files are written.
TEST_F(TenonStoppedRunTest, ASignalWhileTheResultsAreWrittenLosesNone) {
  for (const char* signal : {"INT", "TERM"}) {
    fs::remove_all(out);
    const Result result =
        RunCommand("bash -c '" + app + " flat --duration 10" + Out() + " & run=$!; until [ -e " +
                   (out / "summary.json").string() + " ]; do kill -0 $run || exit 99; done; kill -" + signal +
                   " $run; wait $run'");
    EXPECT_EQ(result.exit_code, 0) << result.text;
    EXPECT_THAT(result.text, HasSubstr("com_error_max_m"));
    EXPECT_TRUE(fs::exists(out / "report.html"));
  }
}

TEST_F(TenonStoppedRunTest, PlacesThatCannotBeWrittenAreExitCode5) {
  const std::string stand = app + " stand --duration 0.1", full = " 2>&1 >/dev/full'";
  for (const auto& [command, place] :
       {std::pair{stand + " --out /dev/full", "'/dev/full'"},
        {"sh -c '" + stand + Out() + full, "stdout"},
        {"sh -c '" + app + " A2 --compare --duration 0.1" + Out() + full, ""},  // more than one buffer
        {stand + Out() + " --graph /nonexistent/a.svg", "--graph /nonexistent/a.svg: "}}) {
    const Result result = RunCommand(command);
    EXPECT_EQ(result.exit_code, 5) << command << ": " << result.text;
    EXPECT_THAT(result.text, HasSubstr(place));
  }
  EXPECT_EQ(RunCommand("sh -c '" + stand + Out() + " 2>/dev/full'").exit_code, 0) << "progress is optional";
}

TEST_F(TenonStoppedRunTest, TheGraphIsDrawnWithoutAShell) {
  fs::create_directories(out);
  const fs::path crafted = out / "a\"; touch pwned; \".svg";
  const Result result = RunCommand("cd " + out.string() + " && " + app + " stand --duration 0.1" + Out() +
                                   " --graph '" + crafted.string() + "'");
  EXPECT_EQ(result.exit_code, 0) << result.text;
  EXPECT_THAT(ReadText(crafted), HasSubstr("<svg"));
  EXPECT_FALSE(fs::exists(out / "pwned"));
  const fs::path svg = out / "b.svg";
  for (int i = 0; i < 5; ++i) {
    const Result without =
        RunCommand("PATH=/nonexistent " + app + " stand --duration 0.1" + Out() + " --graph " + svg.string());
    EXPECT_EQ(without.exit_code, 2);
    EXPECT_THAT(without.text, HasSubstr("apt-get install graphviz"));
    EXPECT_FALSE(fs::exists(svg));
  }
}

TEST_F(TenonStoppedRunTest, AGraphThatCannotBeWrittenLeavesTheOneBefore) {
  Write("bin/dot", "#!/bin/sh\nexit 1\n");  // like on a full disk
  fs::permissions(out / "bin" / "dot", fs::perms::owner_all);
  Write("graph.svg", "of before");
  const Result result =
      RunCommand("PATH=" + (out / "bin").string() + ":$PATH " + app + " stand --duration 0.1" + Out() +
                 " --graph " + (out / "graph.svg").string());
  EXPECT_EQ(result.exit_code, 5);
  EXPECT_THAT(result.text, HasSubstrs("graph.svg'", "`dot`", "disk"));
  EXPECT_EQ(ReadText(out / "graph.svg"), "of before");
  for (const auto& entry : fs::directory_iterator(out))
    EXPECT_THAT(entry.path().string(), Not(HasSubstr(".part")));
}

TEST_F(TenonStoppedRunTest, TextThatIsNotUtf8IsRefusedWhenRead) {
  const std::string own = Write("own.yaml", "extends: flat\ncase: caf\xe9\n");
  const std::string place = (out / "caf\xe9").string();
  fs::create_directories(place);
  for (const auto& [command, where] :
       {std::pair{app + " " + own + Out(), "own.yaml:2:10: byte 0xe9"},
        {app + " flat --out '" + place + "'", "argument 3 of the command line"},
        {"cd '" + place + "' && " + app + " flat", "caf\\xe9"}}) {
    const Result result = RunCommand(command);
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_THAT(result.text, HasSubstr(where));
  }
}

}  // namespace tenon::stopped_run_test
