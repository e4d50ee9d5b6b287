// The example of an app of one's own, as its users run it.

#include <tenon/tests/apps/run_app.h>

#include <fstream>

namespace tenon::own_app_test {
namespace {

namespace fs = std::filesystem;
using test::BadUsage;
using test::Read;
using test::Result;
using test::RunCommand;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

const std::string kApp = CART_APP, kCampaign = TENON_CAMPAIGN, kExample = TENON_APP_EXAMPLE;

using OwnAppTest = test::AppTest;

TEST_F(OwnAppTest, WritesWhatAllAppsWrite) {
  const Result result = RunCommand(kApp + " " + kExample + "/step.yaml --set mass_kg=3 --seed 5" + Out());
  ASSERT_EQ(result.exit_code, 0) << result.text;
  EXPECT_THAT(result.text, AllOf(HasSubstr("error_end_m"), HasSubstr((out / "report.html").string() + "\n")));
  EXPECT_THAT(Read(out / "summary.json"), AllOf(HasSubstr("\"case\": \"step\""), HasSubstr("\"seed\": 5"),
                                                HasSubstr("\"error_end_m\": ")));
  EXPECT_THAT(Read(out / "scenario.yaml"), AllOf(HasSubstr("mass_kg: 3"), HasSubstr("goal_m: 0.2")));
  EXPECT_THAT(Read(out / "report.html").substr(0, 500), HasSubstr("<title>step: a step of 0.2 m"));
  // m x'' + d x' + k x = k 0.2 with m 3, d 6, k 10 from 1 s on is at 10 s within exp(-9) of its goal.
  EXPECT_NEAR(test::Column(out, "cart.x.position [m]").back(), 0.2, 2e-4);
}

TEST_F(OwnAppTest, ListsItsKeys) {
  const Result result = RunCommand(kApp + " --keys");
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.text,
              AllOf(HasSubstr("damping_N_s_per_m"), HasSubstr("N s/m"), HasSubstr("log_rate_hz")));
  EXPECT_EQ(RunCommand(kApp + " --version").text.find("cart-app "), 0U);
}

// A campaign runs the program, a process for each run, and knows its figures.
TEST_F(OwnAppTest, IsRunByCampaigns) {
  fs::create_directories(out);
  fs::copy(kExample + "/step.yaml", out / "step.yaml");
  const auto campaign = [&](const std::string& text) {
    std::ofstream(out / "masses.yaml") << "app: " << kApp << "\nscenario: step.yaml\n" << text;
    return RunCommand("cd / && " + kCampaign + " " + (out / "masses.yaml").string() + " --out " +
                      (out / "runs").string());
  };
  const Result result = campaign("vary: {mass_kg: {grid: [1, 4]}}\nduration_s: 2\n");
  ASSERT_EQ(result.exit_code, 0) << result.text;
  EXPECT_THAT(result.text, HasSubstr("2 of 2 survived"));
  const std::string table = Read(out / "runs/runs.csv");
  EXPECT_THAT(table, AllOf(HasSubstr("run,seed,mass_kg,case,finished"), HasSubstr("error_end_m"),
                           HasSubstr("\n1,1,4,step,true,false,2,")));
  // What it was asked is there with paths that mean the same anywhere.
  EXPECT_THAT(Read(out / "runs/campaign.yaml"), HasSubstr((out / "step.yaml").string()));
  const Result refused = campaign("vary: {mass_kg: {list: [heavy]}}\n");
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.text, AllOf(HasSubstr("masses.yaml: no run can begin"),
                                  HasSubstr("mass_kg: expected a number, found 'heavy'")));
  const Result slow = campaign("duration_s: 1e6\nwall_limit_s: 0.5\n");
  EXPECT_THAT(slow.text, HasSubstr("0 of 1 survived"));
  EXPECT_THAT(Read(out / "runs/runs.csv"), HasSubstr("took longer than 0.5 s"));
  EXPECT_THAT(Read(out / "runs/runs.csv"), Not(HasSubstr("step,true")));
  fs::remove(out / "step.yaml");
  EXPECT_THAT(campaign("").text, AllOf(HasSubstr("masses.yaml:2:11: scenario"), HasSubstr("no such file")));
}

// Ctrl-C in a terminal goes to the campaign and to what it runs.
TEST_F(OwnAppTest, CtrlCEndsAReplayInGoodOrder) {
  fs::create_directories(out);
  fs::copy(kExample + "/step.yaml", out / "step.yaml");
  std::ofstream(out / "long.yaml") << "app: " << kApp << "\nscenario: step.yaml\nduration_s: 1e6\n";
  const std::string runs = (out / "runs").string();
  const Result result =
      RunCommand("bash -c 'set -m; " + kCampaign + " " + (out / "long.yaml").string() + " --replay 0 --out " +
                 runs + " & run=$!; until [ $(wc -l 2>/dev/null < " + runs +
                 "/run_0/signals.csv || echo 0) -gt 12 ]; do kill -0 $run || exit 99; "
                 "sleep 0.02; done 2>/dev/null; kill -INT -- -$run; wait $run'");
  EXPECT_EQ(result.exit_code, 130) << result.text;
  EXPECT_THAT(Read(out / "runs/run_0/summary.json"), HasSubstr("\"end_reason\": \"interrupted\""));
  EXPECT_THAT(Read(out / "runs/run_0/report.html"), HasSubstr("</html>"));
}

// Programs that are none, or do not keep to what an app does.
TEST_F(OwnAppTest, CampaignsSayWhatProgramsDoWrong) {
  fs::create_directories(out);
  std::ofstream(out / "scenario.yaml") << "case: a\n";
  const auto campaign = [&](const std::string& script) {
    std::ofstream(out / "app.sh") << "#!/bin/sh\n" << script;
    fs::permissions(out / "app.sh", fs::perms::owner_all);
    std::ofstream(out / "campaign_file.yaml") << "app: ./app.sh\nscenario: scenario.yaml\n";
    return RunCommand(kCampaign + " " + (out / "campaign_file.yaml").string() + " --out " +
                      (out / "runs").string())
        .text;
  };
  EXPECT_THAT(campaign("[ $2 = --keys ] && exit 0; echo broken; exit 7\n"),
              HasSubstr("1 failed: app.sh ended with 7: broken"));
  EXPECT_THAT(campaign("[ $2 = --keys ] && exit 0; mkdir -p $3; echo '[]' >$3/summary.json\n"),
              HasSubstr("summary.json'"));
  EXPECT_THAT(campaign("echo I do not like it; exit 2\n"),
              AllOf(HasSubstr("no run can begin"), HasSubstr("I do not like it")));
  std::ofstream(out / "campaign_file.yaml") << "app: ./gone\nscenario: scenario.yaml\n";
  EXPECT_THAT(RunCommand(kCampaign + " " + (out / "campaign_file.yaml").string()).text,
              HasSubstr("cannot run '" + (out / "gone").string() + "'"));
}

// What survives ends with 0; a run that writes its figures and then fails does not, here nor after --resume.
TEST_F(OwnAppTest, WhatEndsBadlyDoesNotSurvive) {
  fs::create_directories(out);
  std::ofstream(out / "scenario.yaml") << "case: a\n";
  std::ofstream(out / "app.sh") << "#!/bin/sh\n[ $2 = --keys ] && exit 0\nmkdir -p $3\n"
                                   "[ -e gone ] && { echo no more; exit 9; }\n"
                                   "echo '{\"case\": \"a\", \"finished\": true}' >$3/summary.json\n"
                                   "echo and then; exit 139\n";
  fs::permissions(out / "app.sh", fs::perms::owner_all);
  std::ofstream(out / "c.yaml") << "app: ./app.sh\nscenario: scenario.yaml\n";
  const std::string run =
      "cd " + out.string() + " && " + kCampaign + " c.yaml --out " + (out / "runs").string();
  EXPECT_THAT(RunCommand(run).text, HasSubstr("0 of 1 survived"));
  EXPECT_THAT(Read(out / "runs/runs.csv"),
              AllOf(HasSubstr("false"), HasSubstr("app.sh ended with 139: and then")));
  EXPECT_THAT(RunCommand(run + " --replay 0").text, HasSubstr("ended with 139"));
  std::ofstream(out / "gone") << "";
  // The figures of the replay before are not this one's.
  EXPECT_THAT(RunCommand(run + " --replay 0").text, HasSubstr("app.sh ended with 9: no more"));
}

// A program says that it did not finish, and ends as if it had.
TEST_F(OwnAppTest, WhatDidNotFinishDoesNotSurvive) {
  fs::create_directories(out);
  std::ofstream(out / "scenario.yaml") << "case: a\n";
  std::ofstream(out / "app.sh") << "#!/bin/sh\n[ $2 = --keys ] && exit 0\nmkdir -p $3\n"
                                   "echo '{\"case\": \"a\", \"finished\": false}' >$3/summary.json\n";
  fs::permissions(out / "app.sh", fs::perms::owner_all);
  std::ofstream(out / "c.yaml") << "app: ./app.sh\nscenario: scenario.yaml\n";
  const std::string run = kCampaign + " " + (out / "c.yaml").string() + " --out " + (out / "runs").string();
  EXPECT_THAT(RunCommand(run).text, HasSubstr("0 of 1 survived"));
  EXPECT_EQ(RunCommand(run + " --replay 0").exit_code, 3);
}

// A program that hears no signal is ended all the same, some seconds after its time is over, and so is what
// it runs.
TEST_F(OwnAppTest, WhatDoesNotEndInItsTimeIsEnded) {
  fs::create_directories(out);
  std::ofstream(out / "scenario.yaml") << "case: a\n";
  std::ofstream(out / "app.sh")
      << "#!/bin/sh\n[ $2 = --keys ] && exit 0\n"
         "sh -c \"trap '' TERM INT; while :; do echo >$0.lives; sleep 0.1; done\"\n";
  fs::permissions(out / "app.sh", fs::perms::owner_all);
  std::ofstream(out / "c.yaml") << "app: ./app.sh\nscenario: scenario.yaml\nwall_limit_s: 0.2\n";
  EXPECT_THAT(RunCommand("timeout 60 " + kCampaign + " " + (out / "c.yaml").string() + " --out " +
                         (out / "runs").string())
                  .text,
              HasSubstr("0 of 1 survived"));
  EXPECT_THAT(Read(out / "runs/runs.csv"), HasSubstr("took longer than 0.2 s"));
  fs::remove(out / "app.sh.lives");
  EXPECT_EQ(RunCommand("sleep 0.5").exit_code, 0);
  EXPECT_FALSE(fs::exists(out / "app.sh.lives"));
}

using OwnAppUsageTest = test::UsageTest;

TEST_P(OwnAppUsageTest, IsExitCode2WithAMessage) {
  ExpectExitCode2WithItsMessage("cd " + kExample + " && " + kApp);
}

INSTANTIATE_TEST_SUITE_P(
    All, OwnAppUsageTest,
    ::testing::Values(BadUsage{"step.yaml --set mass_kg=-1",
                               "--set mass_kg=-1: mass_kg: block 'cart': mass must be positive"},
                      BadUsage{"step.yaml --set mass=1", "give the value in kg as 'mass_kg'"},
                      BadUsage{"step.yaml --seed -1",
                               "--seed: -1 must be an integer from 0 to 18446744073709551615"},
                      BadUsage{"step.yaml --duration -3", "--duration: -3 must be a positive number"},
                      BadUsage{"step.yaml --set app=tenon-cdpr", "not a scenario of"},
                      BadUsage{"nothing", "cart-app has no shipped scenarios"}));

}  // namespace
}  // namespace tenon::own_app_test
