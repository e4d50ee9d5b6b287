// The example of a user's own app, and campaigns that run such apps.

#include <tenon/tests/apps/run_app.h>

namespace tenon::own_app_test {

namespace fs = std::filesystem;
using test::Result, test::RunCommand, ::testing::AllOf, ::testing::HasSubstr, ::testing::Not;

const std::string kCampaign = TENON_CAMPAIGN, kExample = TENON_APP_EXAMPLE;

struct OwnAppTest : test::AppTest {
  OwnAppTest() : AppTest(CART_APP) {}
};

TEST_F(OwnAppTest, WritesTheFilesOfAllApps) {
  EXPECT_THAT(Run(kExample + "/step.yaml --set mass_kg=3 --seed 5"),
              HasSubstrs("error_end_m", (out / "report.html").string() + "\n"));
  EXPECT_THAT(Summary(), HasSubstrs("\"case\": \"step\"", "\"seed\": 5", "\"error_end_m\": "));
  EXPECT_THAT(ReadText(out / "scenario.yaml"), HasSubstrs("mass_kg: 3", "goal_m: 0.2"));
  EXPECT_THAT(ReadText(out / "report.html").substr(0, 500), HasSubstr("<title>step: a step of 0.2 m"));
  // m x'' + d x' + k x = k 0.2 with m 3, d 6, k 10 from 1 s on is at 10 s within exp(-9) of its goal.
  EXPECT_NEAR(test::Column(out, "cart.x.position [m]").back(), 0.2, 2e-4);
}

TEST_F(OwnAppTest, ListsItsKeys) {
  const Result result = RunCommand(app + " --keys");
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.text, HasSubstrs("damping_N_s_per_m", "N s/m", "log_rate_hz"));
  EXPECT_EQ(RunCommand(app + " --version").text.find("cart-app "), 0U);
}

TEST_F(OwnAppTest, LogsThePortsThatAScenarioNames) {
  const std::string file =
      Write("log.yaml", "extends: " + kExample +
                            "/step.yaml\ncase: log\nlog: {signals: [cart.force]}\n"
                            "report:\n  plots:\n    - {title: reference, signals: [pd.ref]}\n");
  Run(file);
  EXPECT_EQ(test::Column(out, "cart.force [N]"), test::Column(out, "pd.u [N]"));
  EXPECT_EQ(test::Column(out, "pd.ref [m]"), test::Column(out, "ref.output [m]"));
  EXPECT_THAT(ReadText(out / "report.html"), HasSubstr("\"pd.ref\""));
  const std::string wrong =
      Write("wrong.yaml", "extends: log.yaml\nreport:\n  plots:\n    - title: a\n      signals: [pd.reff]\n");
  EXPECT_THAT(Run(wrong, 2), HasSubstrs("wrong.yaml:5:17: report.plots.0.signals.0: ", "'pd.ref'"));
  ExpectRefused(
      {{file + " --set log.signals=[cart.x.velocty]",
        "--set log.signals=[cart.x.velocty]: log.signals.0: the diagram has no port 'cart.x.velocty'"}});
}

// A campaign runs the program in one process per run and reads its figures.
TEST_F(OwnAppTest, IsRunByCampaigns) {
  Write("step.yaml", ReadText(kExample + "/step.yaml"));
  const auto campaign = [&](const std::string& text) {
    const std::string file = Write("masses.yaml", "app: " + app + "\nscenario: step.yaml\n" + text);
    fs::remove(out / "runs/runs.csv");  // a table is never overwritten
    return RunCommand("cd / && " + kCampaign + " " + file + " --out " + (out / "runs").string());
  };
  const Result result = campaign("vary: {mass_kg: {grid: [1, 4]}}\nduration_s: 2\n");
  ASSERT_EQ(result.exit_code, 0) << result.text;
  EXPECT_THAT(result.text, HasSubstr("2 of 2 survived"));
  const std::string table = ReadText(out / "runs/runs.csv");
  EXPECT_THAT(table,
              HasSubstrs("run,seed,mass_kg,case,finished", "error_end_m", "\n1,1,4,step,true,false,2,"));
  // The copy of the campaign has absolute paths.
  EXPECT_THAT(ReadText(out / "runs/campaign.yaml"), HasSubstr((out / "step.yaml").string()));
  const Result refused = campaign("vary: {mass_kg: {list: [heavy]}}\n");
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.text, HasSubstrs("masses.yaml: ", "mass_kg: "));
  const Result slow = campaign("duration_s: 1e6\nwall_limit_s: 0.5\n");
  EXPECT_THAT(slow.text, HasSubstr("0 of 1 survived"));
  EXPECT_THAT(ReadText(out / "runs/runs.csv"), HasSubstr("took longer than 0.5 s"));
  EXPECT_THAT(ReadText(out / "runs/runs.csv"), Not(HasSubstr("step,true")));
  fs::remove(out / "step.yaml");
  EXPECT_THAT(campaign("").text, HasSubstr("masses.yaml:2:11: scenario"));
}

// Ctrl-C in a terminal sends SIGINT to the campaign and to the program that it runs.
TEST_F(OwnAppTest, CtrlCEndsAReplayInGoodOrder) {
  Write("step.yaml", ReadText(kExample + "/step.yaml"));
  const std::string file = Write("long.yaml", "app: " + app + "\nscenario: step.yaml\nduration_s: 1e6\n");
  const std::string runs = (out / "runs").string();
  const Result result = RunCommand("bash -c 'set -m; " + kCampaign + " " + file + " --replay 0 --out " +
                                   runs + " & run=$!; until [ $(wc -l 2>/dev/null < " + runs +
                                   "/run_0/signals.csv || echo 0) -gt 12 ]; do kill -0 $run || exit 99; "
                                   "sleep 0.02; done 2>/dev/null; kill -INT -- -$run; wait $run'");
  EXPECT_EQ(result.exit_code, 130) << result.text;
  EXPECT_THAT(ReadText(out / "runs/run_0/summary.json"), HasSubstr("\"end_reason\": \"interrupted\""));
  EXPECT_THAT(ReadText(out / "runs/run_0/report.html"), HasSubstr("</html>"));
}

/// Campaigns of a shell script that stands for a user's app.
struct ScriptAppTest : OwnAppTest {
  /// Runs a campaign of one run of the script, which succeeds for `--keys`, and returns what it printed.
  Result Campaign(const std::string& script, const std::string& more = "", const std::string& options = "") {
    Write("scenario.yaml", "case: a\n");
    Write("app.sh", "#!/bin/sh\n[ $2 = --keys ] && exit 0\n" + script);
    fs::permissions(out / "app.sh", fs::perms::owner_all);
    const std::string file = Write("c.yaml", "app: ./app.sh\nscenario: scenario.yaml\n" + more);
    if (options.empty()) fs::remove(out / "runs/runs.csv");  // a table is never overwritten
    return RunCommand("timeout 60 " + kCampaign + " " + file + options + " --out " + (out / "runs").string());
  }
  std::string Table() const { return ReadText(out / "runs/runs.csv"); }
};

TEST_F(ScriptAppTest, CampaignsSayWhatProgramsDoWrong) {
  EXPECT_THAT(Campaign("echo broken; exit 7\n").text, HasSubstr("app.sh ended with 7: broken"));
  EXPECT_THAT(Campaign("mkdir -p $3; echo '[]' >$3/summary.json\n").text, HasSubstr("summary.json'"));
  const std::string gone = Write("gone.yaml", "app: ./gone\nscenario: scenario.yaml\n");
  EXPECT_THAT(RunCommand(kCampaign + " " + gone).text, HasSubstr("'" + (out / "gone").string() + "'"));
  Write("refuses.sh", "#!/bin/sh\necho I do not like it; exit 2\n");
  fs::permissions(out / "refuses.sh", fs::perms::owner_all);
  const std::string refuses = Write("refuses.yaml", "app: ./refuses.sh\nscenario: scenario.yaml\n");
  EXPECT_THAT(RunCommand(kCampaign + " " + refuses).text, HasSubstr("I do not like it"));
}

// A run survives only if its program ends with 0. A replay reads no figures of an earlier replay.
TEST_F(ScriptAppTest, ARunThatFailsAfterItsFiguresDoesNotSurvive) {
  const std::string script =
      "mkdir -p $3\n[ -e $0.gone ] && { echo no more; exit 9; }\n"
      "echo '{\"case\": \"a\", \"finished\": true}' >$3/summary.json\n"
      "echo and then; exit 139\n";
  EXPECT_THAT(Campaign(script).text, HasSubstr("0 of 1 survived"));
  EXPECT_THAT(Table(), HasSubstrs("false", "app.sh ended with 139: and then"));
  EXPECT_THAT(Campaign(script, "", " --replay 0").text, HasSubstr("ended with 139"));
  Write("app.sh.gone", "");
  EXPECT_THAT(Campaign(script, "", " --replay 0").text, HasSubstr("app.sh ended with 9: no more"));
}

TEST_F(ScriptAppTest, ARunThatIsNotFinishedDoesNotSurvive) {
  const std::string script = "mkdir -p $3\necho '{\"case\": \"a\", \"finished\": false}' >$3/summary.json\n";
  EXPECT_THAT(Campaign(script).text, HasSubstr("0 of 1 survived"));
  EXPECT_EQ(Campaign(script, "", " --replay 0").exit_code, 3);
}

// A program that ignores signals is killed a few seconds after its time limit, and so are its child
// processes.
TEST_F(ScriptAppTest, ARunThatDoesNotEndInItsTimeIsKilled) {
  EXPECT_THAT(Campaign("sh -c \"trap '' TERM INT; while :; do echo >$0.lives; sleep 0.1; done\"\n",
                       "wall_limit_s: 0.2\n")
                  .text,
              HasSubstr("0 of 1 survived"));
  EXPECT_THAT(Table(), HasSubstr("took longer than 0.2 s of wall-clock time"));
  fs::remove(out / "app.sh.lives");
  EXPECT_EQ(RunCommand("sleep 0.5").exit_code, 0);
  EXPECT_FALSE(fs::exists(out / "app.sh.lives"));
}

// A failure of the machine says nothing about the robot.
TEST_F(ScriptAppTest, FailuresOfTheMachineAreNotResults) {
  const std::string run = "mkdir -p $3\necho '{\"case\": \"a\", \"finished\": true}' >$3/summary.json\n",
                    two = "seeds: {count: 2}\n";
  for (const std::string end : {"kill -KILL $$", "kill -TERM $$", "exit 5", "exit 127"}) {
    const std::string script = "grep -q seed.:.2 $1 && [ ! -e $0.mended ] && " + end + "\n" + run;
    const Result result = Campaign(script, two);
    EXPECT_EQ(result.exit_code, 5) << end << result.text;
    EXPECT_THAT(result.text, HasSubstrs("1 of 1 survived", "--resume")) << end;
    EXPECT_THAT(Table(), Not(HasSubstr("\n1,"))) << end;
    Write("app.sh.mended", "");
    const Result again = Campaign(script, two, " --resume");
    EXPECT_EQ(again.exit_code, 0) << again.text;
    EXPECT_THAT(again.text, HasSubstr("2 of 2 survived")) << end;
    fs::remove(out / "app.sh.mended");
  }
  EXPECT_EQ(Campaign("kill -KILL $$\n", "seeds: {count: 1000}\n").exit_code, 5) << "not a thousand times";
  fs::remove_all(out / "runs");
  EXPECT_EQ(Campaign("kill -KILL $$\n", "", " --replay 0").exit_code, 5);
  EXPECT_EQ(RunCommand("TMPDIR=/no/such " + kCampaign + " " + (out / "c.yaml").string() + " --out " +
                       (out / "runs").string())
                .exit_code,
            5);
}

// The disk of TMPDIR fills in a run, and has space again at --resume. Its 4 MB also hold the file that
// ThreadSanitizer creates there.
TEST_F(ScriptAppTest, AFullTemporaryDirectoryIsNoResult) {
  const fs::path disk = out / "disk";
  fs::create_directories(disk);
  const std::string mounted =
      "unshare -rm sh -c 'mount -t tmpfs -o size=4M tmpfs " + disk.string() + " && TMPDIR=" + disk.string();
  if (RunCommand(mounted + " true'").exit_code != 0) GTEST_SKIP() << "this machine allows no mounts";
  // The program fills the disk and fails like one that does not check what it writes.
  const std::string script =
      "mkdir -p $3\n"
      "grep -q seed.:.2 $1 && [ ! -e $0.mended ] && { head -c 8M /dev/zero >$3/signals.csv; exit 1; }\n"
      "echo '{\"case\": \"a\", \"finished\": true}' >$3/summary.json\n";
  const std::string two = "seeds: {count: 2}\n";
  Campaign(script, two);  // writes the files
  fs::remove_all(out / "runs");
  const Result full = RunCommand(mounted + " " + kCampaign + " " + (out / "c.yaml").string() +
                                 " --jobs 1 --out " + (out / "runs").string() + "'");
  EXPECT_EQ(full.exit_code, 5) << full.text;
  EXPECT_THAT(full.text, HasSubstrs("1 of 1 survived", "TMPDIR", "--resume"));
  EXPECT_THAT(Table(), Not(HasSubstr("\n1,")));
  Write("app.sh.mended", "");
  const Result again = Campaign(script, two, " --resume");
  EXPECT_EQ(again.exit_code, 0) << again.text;
  EXPECT_THAT(again.text, HasSubstr("2 of 2 survived"));
}

// A figure without data is null, and one that was not computed to a number is NaN. Neither is 0.
TEST_F(ScriptAppTest, FiguresWithoutANumberAreCounted) {
  const Result result = Campaign(
      "mkdir -p $3\nseed=$(sed \"s/.*seed.: \\([0-9]*\\).*/\\1/\" $1)\n"
      "case $seed in 1) x=null;; 2) x='\"NaN\"';; *) x=$seed;; esac\n"
      "echo \"{\\\"case\\\": \\\"a\\\", \\\"finished\\\": true, \\\"x\\\": $x}\" >$3/summary.json\n",
      "seeds: {count: 4}\n");
  EXPECT_THAT(result.text, HasSubstr("x has no number in 2 of 4 runs (1 null, 1 NaN)"));
  EXPECT_THAT(Table(), HasSubstrs("\n0,1,a,true,null\n", "\n1,2,a,true,NaN\n"));
  const std::string summary = ReadText(out / "runs/summary.json");
  EXPECT_THAT(summary.substr(summary.find("without_number")), HasSubstrs("\"null\": 1", "\"nan\": 1"));
  EXPECT_THAT(ReadText(out / "runs/report.html"), HasSubstrs("\"missing\":[2]", "\"medians\":[3.5]"));
}

TEST_F(ScriptAppTest, ReasonsHaveNoTemporaryPaths) {
  Campaign("echo $1:3: kp must be positive; exit 2\n");
  EXPECT_THAT(Table(), AllOf(HasSubstr("ended with 2: scenario.yaml:3: kp"), Not(HasSubstr("tenon-"))));
}

TEST_F(ScriptAppTest, ATableThatWasEditedIsRefusedWithItsLine) {
  const std::string script =
      "mkdir -p $3\necho '{\"case\": \"a\", \"finished\": true, \"x\": 1}' >$3/summary.json\n";
  const std::string two = "seeds: {count: 2}\n";
  Campaign(script, two);
  const std::string table = Table();
  ASSERT_EQ(table, "run,seed,case,finished,x\n0,1,a,true,1\n1,2,a,true,1\n");
  for (const auto& [row, why] : {std::pair{"1,2,a,TRUE,1", "TRUE"},
                                 {"1,2,a,,1", "finished"},
                                 {"1,3,a,true,1", "seed"},
                                 {"0,1,a,true,2", "another result"}}) {
    Write("runs/runs.csv", table.substr(0, table.rfind("1,2,a")) + row + "\n");
    const Result result = Campaign(script, two, " --resume");
    EXPECT_EQ(result.exit_code, 2) << row;
    EXPECT_THAT(result.text, HasSubstrs("runs.csv:3: ", why)) << row;
  }
  std::string spreadsheet = "\xEF\xBB\xBF" + table;  // a byte-order mark and carriage returns
  for (std::size_t at = 0; (at = spreadsheet.find('\n', at)) != spreadsheet.npos; at += 2)
    spreadsheet.insert(at, "\r");
  Write("runs/runs.csv", spreadsheet);
  EXPECT_EQ(Campaign(script, two, " --resume").exit_code, 0);
  EXPECT_EQ(Table(), table);
  Write("runs/runs.csv", table + "1,2,a,true,1\n");
  EXPECT_EQ(Campaign(script, two, " --resume").exit_code, 0) << "the same row twice";
}

// Without /dev/null in their place, the table gets a descriptor of messages.
TEST_F(ScriptAppTest, MessagesDoNotReachTheTableIfDescriptorsAreClosed) {
  const std::string script = "mkdir -p $3\necho '{\"case\": \"a\", \"finished\": true}' >$3/summary.json\n";
  Campaign(script);
  const std::string table = Table();
  fs::remove_all(out / "runs");
  const std::string run = kCampaign + " " + (out / "c.yaml").string() + " --out " + (out / "runs").string();
  EXPECT_EQ(RunCommand("sh -c '" + run + " 0<&- 1>&- 2>&-'").exit_code, 0);
  EXPECT_EQ(Table(), table);
}

// A run without a terminal, as some services start it.
TEST_F(OwnAppTest, MessagesDoNotReachTheSignalsIfDescriptorsAreClosed) {
  const std::string run = kExample + "/step.yaml --duration 3";
  Run(run);
  const std::string signals = Signals();
  fs::remove_all(out);
  for (const char* closed : {"0<&- 1>&- 2>&-", "0<&-", "1>&-", "2>&-"}) {
    EXPECT_EQ(RunCommand("sh -c '" + app + " " + run + Out() + " " + closed + "'").exit_code, 0) << closed;
    EXPECT_EQ(Signals(), signals) << closed;
    EXPECT_EQ(Summary().substr(0, 1) + Summary().substr(Summary().size() - 2), "{}\n") << closed;
  }
}

// The help shows the option with several values.
TEST_F(OwnAppTest, OneOptionMaySetSeveralKeys) {
  Run("--set mass_kg=3 goal_m=0.1 " + kExample + "/step.yaml --set seed=5 --duration 0.1");
  EXPECT_THAT(ReadText(out / "scenario.yaml"), HasSubstrs("mass_kg: 3", "goal_m: 0.1", "seed: 5"));
}

TEST_F(OwnAppTest, HelpToAFullDiskIsExitCode5) {
  for (const char* option : {"--help", "--version", "--keys"})
    EXPECT_EQ(RunCommand("sh -c '" + app + " " + option + " >/dev/full'").exit_code, 5) << option;
}

TEST_F(OwnAppTest, ARunDoesNotOverwriteItsScenario) {
  const std::string text = ReadText(kExample + "/step.yaml");
  Write("scenario.yaml", text);
  EXPECT_THAT(Run((out / "scenario.yaml").string(), 2), HasSubstr("choose another --out"));
  Write("mine.yaml", "extends: ./scenario.yaml\nseed: 3\n");
  EXPECT_THAT(Run((out / "mine.yaml").string(), 2), HasSubstr("choose another --out"));
  EXPECT_EQ(ReadText(out / "scenario.yaml"), text);
}

// A link in an output directory may lead to files of the user.
TEST_F(OwnAppTest, FilesBehindLinksAreNotRemoved) {
  Write("mine/scenario.yaml", "mine");
  Write("summary.json", R"({"x": {"end_reason": ""}})");
  fs::create_directory_symlink(out / "mine", out / "x");
  Run(kExample + "/step.yaml --duration 0.1");
  EXPECT_EQ(ReadText(out / "mine/scenario.yaml"), "mine");
}

TEST_F(ScriptAppTest, ReplaysBehindLinksAreNotRemoved) {
  Write("mine/scenario.yaml", "mine");
  fs::create_directories(out / "runs");
  fs::create_directory_symlink(out / "mine", out / "runs/run_0");
  Campaign("mkdir -p $3\necho '{\"case\": \"a\", \"finished\": true}' >$3/summary.json\n");
  EXPECT_EQ(ReadText(out / "mine/scenario.yaml"), "mine");
}

/// Starts a campaign of a program that does not end, and sends a signal to the campaign.
struct SignalledCampaignTest : ScriptAppTest {
  Result Signal(const std::string& signal) {
    Write("scenario.yaml", "case: a\n");
    Write("app.sh",
          "#!/bin/sh\n[ $2 = --keys ] && exit 0\necho $$ >$0.new; mv $0.new $0.pid; exec sleep 600\n");
    fs::permissions(out / "app.sh", fs::perms::owner_all);
    const std::string file = Write("c.yaml", "app: ./app.sh\nscenario: scenario.yaml\n");
    // A campaign inherits from a test that it ignores SIGHUP.
    return RunCommand("sh -c 'env --default-signal=HUP " + kCampaign + " " + file + " --out " +
                      (out / "runs").string() + " & c=$!; until [ -e " + pid +
                      " ]; do sleep 0.01; done; kill -" + signal + " $c; wait $c'");
  }
  /// Returns whether the program ends.
  bool Ends() const {
    const std::string running = "grep -q sleep /proc/$(cat " + pid + ")/cmdline 2>/dev/null";
    return RunCommand("i=0; while " + running +
                      "; do sleep 0.01; i=$((i+1)); [ $i -lt 1000 ] || exit 1; done")
               .exit_code == 0;
  }
  const std::string pid = (out / "app.sh.pid").string();
};

TEST_F(SignalledCampaignTest, ItsProgramsDoNotOutliveIt) {
  EXPECT_EQ(Signal("KILL").exit_code, 137);
  EXPECT_TRUE(Ends());
}

// A terminal that is closed.
TEST_F(SignalledCampaignTest, EndsAtAHangUp) {
  const Result result = Signal("HUP");
  EXPECT_EQ(result.exit_code, 129);
  EXPECT_THAT(result.text, HasSubstr("--resume"));
  EXPECT_TRUE(Ends());
}

TEST_F(OwnAppTest, RefusesBadUsage) {
  const std::string step = kExample + "/step.yaml";
  ExpectSettingsRefused(step, {"mass=1"});
  ExpectRefused({{step + " --set mass_kg=-1", "--set mass_kg=-1: mass_kg: block 'cart': "},
                 {step + " --seed -1", "--seed: -1"},
                 {step + " --seed 1.5", "--seed: 1.5"},
                 {step + " --seed 1e300", "--seed: 1e300"},
                 {step + " --set seed=-1", "--set seed=-1: seed: "},
                 {step + " --duration -3", "--duration: -3"},
                 {step + " --set app=tenon-cdpr", "run tenon-cdpr"},
                 {"nothing", "cart-app"}});
}

}  // namespace tenon::own_app_test
