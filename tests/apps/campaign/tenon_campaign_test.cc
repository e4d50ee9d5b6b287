// The command line of tenon-campaign, and the tables and reports that it writes.

#include <tenon/systems/version.h>
#include <tenon/tests/apps/run_app.h>

#include <map>

namespace tenon::test::tenon_campaign_test {

namespace fs = std::filesystem;
using ::testing::AllOf, ::testing::HasSubstr, ::testing::Not;

const std::string kApp = TENON_CAMPAIGN;

/// A table without the columns of measured times.
std::string Comparable(const fs::path& table) {
  std::istringstream in(ReadText(table));
  std::string line, cell, text;
  std::vector<bool> kept;
  while (std::getline(in, line)) {
    std::istringstream cells(line);
    for (std::size_t i = 0; std::getline(cells, cell, ','); ++i) {
      if (text.empty() || i >= kept.size())
        kept.push_back(!cell.starts_with("wall") && !cell.starts_with("qp_time") &&
                       !cell.starts_with("mpc_time") && !cell.starts_with("real_time"));
      if (kept[i]) text += cell + ',';
    }
    text += '\n';
  }
  return text;
}

/// The rows of a table by their runs.
std::map<int, std::string> Rows(const fs::path& table) {
  std::istringstream in(ReadText(table));
  std::string line;
  std::getline(in, line);
  std::map<int, std::string> rows;
  while (std::getline(in, line)) rows[std::stoi(line)] = line;
  return rows;
}

struct TenonCampaignTest : AppTest {
  TenonCampaignTest() { fs::create_directories(out); }
  std::string File(const std::string& text) const { return Write("campaign_file.yaml", text); }
  std::string Walks(int seeds) const {
    return File("app: tenon-quadruped\nscenario: A4\nduration_s: 0.05\nseeds: {first: 101, count: " +
                std::to_string(seeds) +
                "}\nset: {walk.friction: 0.6}\nvary: {random_forces.0.upper_N: {grid: [20, 35]}}\n");
  }
  std::string Run(const std::string& arguments, int exit_code = 0) const {
    const Result result = RunCommand(kApp + " " + arguments);
    EXPECT_EQ(result.exit_code, exit_code) << result.text;
    return result.text;
  }
  std::string To(const std::string& name) const { return " --out " + (out / name).string(); }
  std::string Table(const std::string& name) const { return Comparable(out / name / "runs.csv"); }
};

TEST_F(TenonCampaignTest, WritesARowForEachRunAndAReport) {
  const std::string text = Run(Walks(3) + To("c") + " --jobs 1");
  EXPECT_THAT(text, HasSubstrs("6 of 6 survived", "random_forces.0.upper_N=35: 3 of 3", "--replay"));
  const std::string table = ReadText(out / "c/runs.csv");
  EXPECT_EQ(table.find("run,seed,random_forces.0.upper_N,case,finished,"), 0U);
  EXPECT_EQ(table.substr(table.find('\n') - 10, 10), "end_reason");
  const auto rows = Rows(out / "c/runs.csv");
  EXPECT_EQ(rows.size(), 6U);
  EXPECT_EQ(rows.at(0).find("0,101,20,A4,true,false,0.05,"), 0U);
  EXPECT_EQ(rows.at(5).find("5,103,35,A4,true,false,0.05,"), 0U);
  EXPECT_THAT(table, HasSubstr(",tenon,"));
  EXPECT_THAT(rows.at(0), HasSubstr(std::string(",") + Version()));
  EXPECT_THAT(ReadText(out / "c/summary.json"),
              HasSubstrs("\"runs\": 6", "\"survived\": 6", std::string("\"tenon\": \"") + Version()));
  EXPECT_THAT(ReadText(out / "c/report.html"), HasSubstr("\"figures\":[\"simulated_s\""));
}

// The result of a run depends only on its index.
TEST_F(TenonCampaignTest, ThreadsPartsAndKillsDoNotShowInTheTable) {
  const std::string file = Walks(8);
  Run(file + To("one") + " --jobs 1");
  const std::string whole = Table("one");
  EXPECT_EQ(Rows(out / "one/runs.csv").size(), 16U);
  Run(file + To("two") + " --jobs 2");
  EXPECT_EQ(Table("two"), whole);

  for (const std::string i : {"1", "2", "3"}) Run(file + To("part" + i) + " --shard " + i + "/3");
  const std::string part = (out / "part").string();
  EXPECT_THAT(Run("--merge " + part + "1 " + part + "3" + To("some")),
              HasSubstrs("warning: 5 of 16 runs", "--resume"));
  Run((out / "some/campaign.yaml").string() + To("some") + " --resume");
  EXPECT_EQ(Table("some"), whole);
  Run("--merge " + part + "3 " + part + "1 " + part + "2" + To("all"));
  EXPECT_EQ(Table("all"), whole);

  for (const std::string signal : {"KILL", "INT"}) {
    // The signal is sent after the third row.
    const Result killed = RunCommand(
        "sh -c '" + kApp + " " + file + To("killed" + signal) + " --jobs 2 & c=$!; " + "until [ \"$(cat " +
        (out / ("killed" + signal)).string() +
        "/runs.csv 2>/dev/null | wc -l)\" -gt 3 ]; do sleep 0.01; done; kill -" + signal + " $c; wait $c'");
    EXPECT_EQ(killed.exit_code, signal == "INT" ? 130 : 137) << killed.text;
    EXPECT_THAT(Run(file + To("killed" + signal) + " --resume --jobs 2"), HasSubstr("16 of 16 survived"));
    EXPECT_EQ(Table("killed" + signal), whole);
  }
}

TEST_F(TenonCampaignTest, AFailedRunIsARowWithItsReason) {
  // A friction of 0 is refused; the large force throws the robot into the air.
  const std::string file = File(
      "app: tenon-quadruped\nscenario: A1\nduration_s: 0.6\nset: {forces.0.on: trunk, forces.0.start_s: 0}\n"
      "vary:\n  forces.0.force_N: {list: [[0, 0, 0], [0, 0, 9e4]]}\n  walk.friction: {grid: [0, 0.6]}\n");
  const std::string text = Run(file + To("c"));
  EXPECT_THAT(text, HasSubstrs("2 of 4 points", "1 of 4 survived", "2 failed: ", "walk.friction: "));
  const auto rows = Rows(out / "c/runs.csv");
  EXPECT_THAT(rows.at(0), HasSubstrs("false", "walk.friction: "));
  EXPECT_THAT(rows.at(1), HasSubstr("end of the run"));
  EXPECT_THAT(rows.at(3), HasSubstrs("false,false", "left the ground"));
}

TEST_F(TenonCampaignTest, ARunEndsAtItsWallLimit) {
  const std::string file = File("app: tenon-quadruped\nscenario: A4\nduration_s: 30\nwall_limit_s: 0.2\n");
  EXPECT_THAT(Run(file + To("c")), HasSubstr("took longer than 0.2 s"));
  EXPECT_THAT(Rows(out / "c/runs.csv").at(0), HasSubstr("A4,false,false"));
}

TEST_F(TenonCampaignTest, RunsEveryAppAndScenariosWithDistributions) {
  for (const std::string scenario : {"tenon-guide-dog C1", "tenon-cdpr D1", "tenon-quadruped B2"}) {
    const std::size_t blank = scenario.find(' ');
    const std::string file =
        File("app: " + scenario.substr(0, blank) + "\nscenario: " + scenario.substr(blank) +
             "\nduration_s: 0.05\nseeds: {count: 2}\n");
    EXPECT_THAT(Run(file + To("c" + scenario.substr(blank + 1))), HasSubstr("2 of 2 survived")) << scenario;
  }
  std::ofstream(out / "random.yaml") << "extends: B1-flat\npayload: {mass_kg: {uniform: [10, 20]}}\n";
  const std::string file = File("app: tenon-quadruped\nscenario: " + (out / "random.yaml").string() +
                                "\nduration_s: 0.05\nseeds: {count: 2}\n");
  Run(file + To("c"));
  const std::string table = ReadText(out / "c/runs.csv");
  EXPECT_EQ(table.find("run,seed,payload.mass_kg,case,"), 0U);
  const auto rows = Rows(out / "c/runs.csv");
  EXPECT_NE(rows.at(0).substr(4, 8), rows.at(1).substr(4, 8));
}

TEST_F(TenonCampaignTest, ARunIsRepeatedWithItsFiles) {
  const std::string file = Walks(2);
  Run(file + To("c"));
  EXPECT_THAT(ReadText(out / "c/report.html"), Not(HasSubstr("run_3/report.html")));
  EXPECT_THAT(Run(file + To("c") + " --replay 3"), Not(HasSubstr("warning")));
  for (const std::string name : {"report.html", "signals.csv", "summary.json", "scenario.yaml"})
    EXPECT_TRUE(fs::exists(out / "c/run_3" / name)) << name;
  EXPECT_THAT(ReadText(out / "c/run_3/scenario.yaml"), HasSubstrs("upper_N: 35", "seed: 102"));
  EXPECT_THAT(ReadText(out / "c/report.html"), HasSubstr("run_3/report.html"));
  EXPECT_THAT(Run(file + To("c") + " --replay 4", 2), HasSubstr("0 to 3"));
  const Result taken =
      RunCommand("flock " + (out / "c").string() + " " + kApp + " " + file + To("c") + " --replay 3");
  EXPECT_EQ(taken.exit_code, 2) << "while the campaign runs";
  EXPECT_THAT(taken.text, HasSubstr((out / "c").string()));
}

TEST_F(TenonCampaignTest, WarnsOfADurationThatIsTooShortForTheFigures) {
  const std::string file =
      File("app: tenon-quadruped\nscenario: flat\nduration_s: 0.1\nset: {walk.judged_from_s: 2}\n");
  EXPECT_THAT(Run(file + To("c")), HasSubstr("duration_s"));
}

TEST_F(TenonCampaignTest, EstimatesAndFindsLimitsTheSameWithAnyNumberOfThreads) {
  const std::string head = "app: tenon-quadruped\nscenario: stand\nduration_s: 0.3\nseeds: {count: 40}\n";
  const std::string load = "[{on: trunk, force_N: [0, 0, -1], duration_s: 1}]";
  const std::string file =
      File(head + "set:\n  forces: " + load +
           "\nlimit: {key: forces.0.factor, from: 0, to: 8000, steps: 4, probability: 0.5}\n");
  const std::string text = Run(file + To("one") + " --jobs 1");
  EXPECT_THAT(text, HasSubstr("forces.0.factor: survives "));
  Run(file + To("two") + " --jobs 2");
  EXPECT_EQ(Table("two"), Table("one"));
  EXPECT_EQ(ReadText(out / "two/summary.json"), ReadText(out / "one/summary.json"));

  const std::string estimate = File(head + "estimate: survival\ninterval_width: 0.3\n");
  EXPECT_THAT(Run(estimate + To("e1") + " --jobs 1"), HasSubstr("9 of 9 survived"));
  Run(estimate + To("e2") + " --jobs 2");
  EXPECT_EQ(Table("e2"), Table("e1"));
}

// An estimate that was interrupted has no result.
TEST_F(TenonCampaignTest, HalfAnEstimateIsNoResult) {
  const std::string file = File(
      "app: tenon-quadruped\nscenario: stand\nduration_s: 0.05\nseeds: {count: 40}\nestimate: survival\n"
      "interval_width: 0.3\nworst_by: com_error\n");
  EXPECT_THAT(Run(file + To("whole") + " --jobs 1"), HasSubstr("worst_by: "));
  const std::string merge = "--merge " + (out / "whole").string() + To("merged");
  EXPECT_THAT(Run(merge), HasSubstr("9 of 9 survived"));
  fs::remove(out / "whole/report.html");  // like a campaign that was stopped
  const std::string table = ReadText(out / "whole/runs.csv");
  std::size_t end = 0;
  for (int line = 0; line < 5; ++line) end = table.find('\n', end) + 1;
  std::ofstream(out / "whole/runs.csv") << table.substr(0, end);
  EXPECT_THAT(Run(merge, 2), HasSubstrs("is not finished", "--resume"));
  Run(file + To("whole") + " --replay 2");
  EXPECT_FALSE(fs::exists(out / "whole/report.html"));
}

// One of four runs is refused, so the largest of the values that count for the quantile is infinite.
TEST_F(TenonCampaignTest, JudgesQuantilesOfAllRuns) {
  const std::string text = Run(File("app: tenon-quadruped\nscenario: A4\nduration_s: 0.3\nseeds: {count: 3}\n"
                                    "confidence: 0.5\ngoals:\n"
                                    "  - {figure: slip_max_m, quantile: 0.5, at_most: 1}\n"
                                    "  - {figure: slip_max_m, quantile: 0.5, at_most: 0}\n"
                                    "  - {figure: height_min_m, at_least: 0}\n"
                                    "vary: {robot: {list: [dogbot, nobody]}}\n") +
                               To("c"));
  EXPECT_THAT(text, HasSubstrs("slip_max_m at most 1 for 50 % of the runs: open, ",
                               "slip_max_m at most 0 for 50 % of the runs: missed, ",
                               "warning: goals: no run has a figure 'height_min_m'"));
  EXPECT_THAT(ReadText(out / "c/summary.json"),
              HasSubstrs("\"at_most\": 1", "\"high\": null", "\"verdict\": \"missed\""));
  const std::string wrong = "app: tenon-quadruped\nscenario: A4\ngoals: [{figure: slip_max_m}]\n";
  EXPECT_THAT(Run(File(wrong) + To("d"), 2), HasSubstrs("goals", "slip_max_m"));
}

// A varied key that is also a figure has one column in the table.
TEST_F(TenonCampaignTest, AFigureMayBeWhatVaries) {
  const std::string file = File(
      "app: tenon-cdpr\nscenario: D1\nduration_s: 0.02\n"
      "vary:\n  controller: {list: [pd, mpc_zero]}\n  robot: {list: [cdpr_4, nobody]}\n");
  for (const std::string i : {"1", "2"}) Run(file + To("part" + i) + " --shard " + i + "/2");
  const std::string part = (out / "part").string();
  Run("--merge " + part + "1 " + part + "2" + To("a"));
  Run("--merge " + part + "2 " + part + "1" + To("b"));
  EXPECT_EQ(Table("a"), Table("b"));
  EXPECT_EQ(ReadText(out / "a/runs.csv").find("run,seed,controller,robot,case,finished,"), 0U);
  EXPECT_THAT(ReadText(out / "a/summary.json"), HasSubstr("'nobody'"));
  EXPECT_THAT(ReadText(out / "a/report.html"), HasSubstr("\"tracking_error_rms_m\""));
}

TEST_F(TenonCampaignTest, ARefusedStartLeavesTheOldRows) {
  const std::string file = Walks(1), place = (out / "c").string();
  Run(file + To("c"));
  const std::string table = ReadText(out / "c/runs.csv"), report = ReadText(out / "c/report.html");
  EXPECT_THAT(Run("--merge " + place + To("c"), 2), HasSubstr("--out"));
  EXPECT_THAT(Run("--merge " + place + " " + (out / "none").string() + To("d"), 2), HasSubstr("no campaign"));
  EXPECT_FALSE(fs::exists(out / "d"));
  EXPECT_THAT(Run(Walks(3) + To("c") + " --resume", 2), HasSubstr("another campaign"));
  EXPECT_THAT(Run(Walks(3) + To("c") + " --replay 1", 2), HasSubstr("choose another --out"));
  EXPECT_EQ(ReadText(out / "c/runs.csv"), table);
  EXPECT_EQ(ReadText(out / "c/report.html"), report);
}

TEST_F(TenonCampaignTest, APartMayBeEmpty) {
  const std::string file = Walks(1);
  std::string merge = "--merge";
  for (const std::string i : {"1", "2", "3"}) {
    Run(file + To("part" + i) + " --shard " + i + "/3");
    merge += " " + (out / ("part" + i)).string();
  }
  EXPECT_EQ(ReadText(out / "part3/runs.csv"), "");
  EXPECT_THAT(Run(merge + To("all")), HasSubstr("2 of 2 survived"));
  Run(file + To("part3") + " --shard 3/3 --resume");
}

TEST_F(TenonCampaignTest, ATableWithRunsIsNeverOverwritten) {
  const std::string file = Walks(1);
  Run(file + To("c"));
  Run(file + To("c") + " --replay 0");
  const std::string table = ReadText(out / "c/runs.csv");
  for (const std::string& again : {file, Walks(2)})
    EXPECT_THAT(Run(again + To("c"), 2), HasSubstrs("c/runs.csv", "--resume", (out / "c_2").string()));
  EXPECT_EQ(ReadText(out / "c/runs.csv"), table);
  EXPECT_TRUE(fs::exists(out / "c/run_0/report.html"));
  // A merge may be repeated, but loses no run.
  for (const std::string i : {"1", "2"}) Run(Walks(1) + To("part" + i) + " --shard " + i + "/2");
  const std::string part = (out / "part").string();
  Run("--merge " + part + "1" + To("all"));
  Run("--merge " + part + "1 " + part + "2" + To("all"));
  EXPECT_THAT(Run("--merge " + part + "2" + To("all"), 2), HasSubstr("run 0"));
  EXPECT_EQ(Rows(out / "all/runs.csv").size(), 2U);
}

TEST_F(TenonCampaignTest, ADryRunShowsAndRunsNothing) {
  EXPECT_THAT(Run(Walks(3) + To("c") + " --dry-run"),
              HasSubstrs("2 points, 3 seeds each, 6 runs", "run=3  seed=101  random_forces.0.upper_N=35"));
  EXPECT_FALSE(fs::exists(out / "c"));
}

TEST_F(TenonCampaignTest, ATableThatCannotBeWrittenIsExitCode5) {
  // Files are limited to 12 blocks of 512 bytes, which hold about ten rows.
  const Result result = RunCommand("sh -c 'ulimit -f 12; exec " + kApp + " " + Walks(15) + To("c") + "'");
  EXPECT_EQ(result.exit_code, 5) << result.text;
  EXPECT_THAT(result.text, HasSubstrs("runs.csv", "File too large"));
  // The rows that were written are complete, and --resume continues after them.
  const std::size_t rows = Rows(out / "c/runs.csv").size();
  EXPECT_GT(rows, 3U);
  EXPECT_LT(rows, 30U);
  Run(Walks(15) + To("c") + " --resume");
  EXPECT_EQ(Rows(out / "c/runs.csv").size(), 30U);
}

TEST_F(TenonCampaignTest, RefusesBadUsage) {
  const std::string quadruped = "app: tenon-quadruped\nscenario: A4\n";
  for (const auto& [text, place] : std::vector<std::pair<std::string, std::string>>{
           {"app: tenon-fish\nscenario: A4\n", ":1:6: app: "},
           {"app: tenon-quadruped\nscenario: A44\n", ":2:11: scenario: "},
           {"app: tenon-cdpr\nscenario: A4\n", ":2:11: scenario: "},
           {quadruped + "vary: {walk.frictoin: {grid: [1]}}\n", ":3:23: vary.walk.frictoin: "},
           {quadruped + "set: {profile: {file: standard, sway: 1}}\n", "set.profile: "},
           {quadruped + "set: {profile: [60]}\n", "set.profile: "}})
    EXPECT_THAT(Run(File(text) + To("c"), 2), HasSubstr(place)) << text;
  const std::string good = File(quadruped) + To("c");
  EXPECT_THAT(Run(good + " --shard 0/4", 2), HasSubstr("--shard 0/4"));
  EXPECT_THAT(Run(good + " --shard 5/4", 2), HasSubstr("--shard 5/4"));
  EXPECT_THAT(Run(good + " --jobs 0", 2), HasSubstr("--jobs"));
  EXPECT_THAT(Run(File(quadruped + "estimate: survival\n") + To("c") + " --shard 1/4", 2),
              HasSubstr("cannot be divided"));
  EXPECT_THAT(Run("no_such_campaign", 2), HasSubstr("'no_such_campaign'"));
  EXPECT_THAT(Run("", 2), HasSubstr("no campaign given"));
  EXPECT_THAT(Run("--merge " + out.string(), 2), HasSubstr("--out"));
}

TEST_F(TenonCampaignTest, EveryShippedCampaignCanBegin) {
  std::istringstream list(Run("--list"));
  std::string line;
  int count = 0;
  for (; std::getline(list, line); ++count) {
    const std::string name = line.substr(0, line.find(' '));
    EXPECT_THAT(Run(name + " --dry-run"), AllOf(HasSubstr("run="), Not(HasSubstr("refused")))) << name;
    EXPECT_GT(line.size(), name.size() + 20) << "each campaign has a description: " << line;
  }
  EXPECT_GT(count, 5);
}

/// Campaigns that mpirun runs in several processes.
struct TenonCampaignMpiTest : TenonCampaignTest {
  void SetUp() override {
    if (RunCommand("command -v mpirun").exit_code == 0) return;
    ASSERT_EQ(std::getenv("TENON_REQUIRE_CLUSTER"), nullptr) << "mpirun is not installed";
    GTEST_SKIP() << "mpirun is not installed: apt-get install openmpi-bin";
  }
  /// The leak check of AddressSanitizer is off, because Open MPI leaks.
  static std::string Ranks(int count) {
    return "OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 LSAN_OPTIONS=detect_leaks=0 "
           "mpirun --oversubscribe -n " +
           std::to_string(count) + " " + kApp + " ";
  }
  /// Returns a shell command that sends a signal to the ranks whose number matches. Each rank has its number
  /// in its environment.
  std::string SignalRanks(const std::string& signal, const std::string& name, const std::string& rank) const {
    return "for p in $(pgrep -f " + (out / name).string() +
           "); do if tr \"\\0\" \"\\n\" < /proc/$p/environ | grep -qx OMPI_COMM_WORLD_RANK=" + rank +
           "; then kill -" + signal + " $p; fi; done";
  }
  /// Starts three ranks, stops them by a shell command after some rows, resumes with two ranks and expects
  /// the table "one". Returns the output of the stopped ranks.
  std::string ExpectResumes(const std::string& file, std::size_t all, const std::string& name,
                            const std::string& stop) const {
    const std::string table = (out / name / "runs.csv").string();
    const Result stopped =
        RunCommand("sh -c '" + Ranks(3) + file + To(name) + " & c=$!; until [ \"$(cat " + table +
                   " 2>/dev/null | wc -l)\" -gt 3 ]; do sleep 0.01; done; " + stop + "; wait $c'");
    EXPECT_NE(stopped.exit_code, 0) << stopped.text;
    const std::size_t rows = Rows(table).size();
    EXPECT_GE(rows, 3U);
    EXPECT_LT(rows, all);
    const Result resumed = RunCommand(Ranks(2) + file + To(name) + " --resume");
    EXPECT_EQ(resumed.exit_code, 0) << resumed.text;
    EXPECT_EQ(Table(name), Table("one"));
    return stopped.text;
  }
};

TEST_F(TenonCampaignMpiTest, RanksDoNotShowInTheTable) {
  const std::string file = Walks(8);
  Run(file + To("one") + " --jobs 1");
  for (const int ranks : {1, 2, 3}) {
    const std::string name = "ranks" + std::to_string(ranks);
    const Result result = RunCommand(Ranks(ranks) + file + To(name));
    EXPECT_EQ(result.exit_code, 0) << result.text;
    EXPECT_EQ(Table(name), Table("one"));
  }
}

TEST_F(TenonCampaignMpiTest, AKilledRankOrWriterLosesNothing) {
  const std::string file = Walks(100);
  Run(file + To("one") + " --jobs 1");
  for (const std::string rank : {"0", "2"}) {
    const std::string name = "killed" + rank;
    ExpectResumes(file, 200, name, SignalRanks("KILL", name, rank));
  }
}

// After Ctrl-C, mpirun sends SIGTERM to the ranks. When a rank has ended, it kills the others after twice
// this time [s]; the default of 1 s is too short for an orderly end on a busy machine.
TEST_F(TenonCampaignMpiTest, TerminatedRanksEndInGoodOrder) {
  ASSERT_EQ(setenv("OMPI_MCA_odls_base_sigkill_timeout", "3", 1), 0);
  const std::string file = Walks(300);
  Run(file + To("one") + " --jobs 1");
  EXPECT_THAT(ExpectResumes(file, 600, "stopped", SignalRanks("TERM", "stopped", "[012]")),
              HasSubstr("interrupted: "));
}

}  // namespace tenon::test::tenon_campaign_test
