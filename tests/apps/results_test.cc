// tools/results: a short campaign, the tables that it makes of given figures, and stale tables.

#include <tenon/tests/apps/run_app.h>

namespace tenon::results_test {

namespace fs = std::filesystem;
using ::testing::AllOf, ::testing::HasSubstr, ::testing::Not;

struct ResultsTest : test::AppTest {
  /// Returns the exit code and sets `text` to stdout and stderr.
  int RunResults(const std::string& arguments) {
    const test::Result result =
        test::RunCommand(std::string("python3 ") + TENON_RESULTS + " --build " + TENON_BUILD + Out() +
                         " --page " + page().string() + " " + arguments);
    text = result.text;
    return result.exit_code;
  }

  /// Writes the files of a finished campaign.
  void Pretend(const std::string& campaign, const std::string& header,
               const std::vector<std::string>& rows) const {
    std::string table = header + '\n';
    for (const std::string& row : rows) table += row + '\n';
    Write(campaign + "/stamp.json",
          R"({"commit": "abcdef0", "date": "2026-01-02", "machine": "a machine", "sources": "1", "done": true,
              "seeds": null, "duration_s": null})");
    Write(campaign + "/runs.csv", table);
  }

  fs::path page() const { return out / "page.md"; }
  std::string Page() const { return ReadText(page()); }

  std::string text;
};

TEST_F(ResultsTest, RunsACampaignAndResumes) {
  const std::string few = "--part hardware_guide_dog --seeds 1 --duration 0.05";
  ASSERT_EQ(RunResults(few), 0) << text;
  EXPECT_THAT(Page(), HasSubstrs("cores, a trial with fewer seeds or shorter runs.*",
                                 "| C3-blocks | rough | yes |", "| A1 | 20 N sin(t) along x"));
  const std::string runs = ReadText(out / "hardware_guide_dog/runs.csv");
  ASSERT_EQ(RunResults(few), 0) << text;
  // The wall times show that nothing ran again.
  EXPECT_EQ(ReadText(out / "hardware_guide_dog/runs.csv"), runs);
}

TEST_F(ResultsTest, JudgesFinishedCampaigns) {
  const std::string figures = ",0.002,0.0035,1.5,0.004,0.011";
  Pretend("cases_fixed",
          "run,seed,name,variant,finished,fell,simulated_s,com_error_max_m,foot_error_max_m.front_left,"
          "foot_error_max_m.rear_right,grf_error_mean_N,slip_max_m.front_left,slip_max_m.rear_right",
          {"0,1,A1,ours,true,false,12.34,0.002" + figures, "1,1,A1,none,false,true,12.34,0.5" + figures});
  Pretend("cases_random",
          "run,seed,name,variant,finished,fell,simulated_s,com_error_max_m,foot_error_max_m.front_left,"
          "foot_error_max_m.rear_right,grf_error_mean_N,slip_max_m.front_left,slip_max_m.rear_right",
          {"0,1,A4,ours,true,false,12.34,0.004" + figures, "1,2,A4,ours,true,false,12.34,0.009" + figures,
           "2,3,A4,ours,false,true,12.34,0.3" + figures});
  Pretend("cases_pushes", "run,seed,name,variant", {});
  ASSERT_EQ(RunResults("--report-only"), 0) << text;
  EXPECT_THAT(
      Page(),
      HasSubstrs("*Commit abcdef0, 2026-01-02, a machine.*",
                 "| yes | 2.0 | 3.5 | 11.0 | 1.5 | – | – | CoM ≤ 3 mm; foot ≤ 4 mm; GRF ≤ 2 N | yes |",
                 "| A1 | none | **falls at 12.3 s** | 500.0 | 250.00 | 3.5 | 1.00 |",
                 "| **2 of 3** (first falls at 12.3 s) | 9.0 / 300.0 | 3.5 / 3.5 |",
                 "**no**: 1 of 3 not finished; median of CoM is 9.0 mm; max of CoM is 300.0 mm (only 3 of "));
}

// The verdict of the cable robot takes the worst seed.
TEST_F(ResultsTest, JudgesEverySeedOfTheCableRobot) {
  std::vector<std::string> rows;
  const auto fly = [&](int seed, double ours, double pd) {
    for (const auto& [controller, settling] :
         {std::pair{"mpc_equilibrium", ours}, {"mpc_zero", 9.0}, {"pd", pd}})
      rows.push_back(std::to_string(rows.size()) + "," + std::to_string(seed) + ",D2," + controller +
                     ",true,false,0.002,7,0.005,0.2," + std::to_string(10 * seed) + ",90,5,99," +
                     std::to_string(settling) + ",0.008,0.02");
  };
  fly(1, 1, 3);
  fly(2, 2, 3);
  Pretend("cases_cdpr",
          "run,seed,name,controller,finished,fell,tracking_error_rms_m,tension_rate_rms_N_per_s,"
          "euler_oscillation_rms_rad,acceleration_rms_m_per_s2,tension_min_N,tension_max_N,command_min_N,"
          "command_max_N,settling_time_s,loaded_error_rms_m,loaded_swing_rms_rad",
          rows);
  ASSERT_EQ(RunResults("--report-only"), 0) << text;
  EXPECT_THAT(Page(),
              HasSubstrs("| D2 | mpc_equilibrium | 2 of 2 | 2.0 / 2.0 | 7.0 / 7.0 | 5.0 / 5.0 | 0.200 / "
                         "0.200 |",
                         "| D2 | mpc_equilibrium | 10 to 90 | 5 to 99 | 8.0 / 8.0 | 20.0 / 20.0 | 1.50 / "
                         "2.00 |",
                         "goal MPC ≤ 3 s: met; goal PD / MPC ≥ 2: **missed** (least ratio 1.5)",
                         "within 10 mm rms: met (8.0 mm at most); settling ≤ 2 s: met"));
}

TEST_F(ResultsTest, ShowsLimitsAndSurvival) {
  for (const char* limit : {"limit_A1", "limit_A3", "limit_B1", "limit_B2"}) Pretend(limit, "run", {});
  std::ofstream(out / "limit_A1/summary.json")
      << R"({"points": [{"at": {"observer": "hybrid"}, "survives": 75, "fails": 80},
                       {"at": {"observer": "none"}, "survives": 315, "fails": 320}]})";
  for (const char* campaign :
       {"survival_B2", "survival_B3_minus", "survival_B3_plus", "survival_C3_blocks"}) {
    Pretend(campaign, "run", {});
    std::ofstream(out / campaign / "summary.json")
        << R"({"scenario": "B2", "runs": 1000, "survived": 995, "survival_low": 0.9883, "survival_high": 0.9979,
             "causes": [{"cause": "the robot fell", "runs": 5}]})";
  }
  ASSERT_EQ(RunResults("--report-only"), 0) << text;
  EXPECT_THAT(Page(), HasSubstrs("| A1, N | 75 | – | – | > 315 |", "| 8 | none random | 5 |",
                                 "| B2 | 1000 | 99.5 | 98.8 to 99.8 |", "- B2, 5 runs: `the robot fell`"));
}

TEST_F(ResultsTest, ThePageIsWellFormed) {
  const test::Result result = test::RunCommand(std::string("python3 ") + TENON_RESULTS + " --due");
  EXPECT_EQ(result.exit_code, 0) << result.text;
  EXPECT_THAT(result.text, HasSubstrs("\nsurvival ", "\nlimits "));
}

/// A small source tree with one table, whose runs depend on controllers/gain.cc and the scenarios walk and
/// flat, and a program that plays the campaign: its summary.json is the file `figures`.
struct StaleResultsTest : ResultsTest {
  void SetUp() override {
    fs::create_directories(out / "tools");
    fs::copy_file(TENON_RESULTS, out / "tools/results");
    Write("apps/results.yaml", R"(
sources: {tenon-quadruped: [controllers/legged]}
sample: []
cases: {A1: {setup: a push, goals: [CoM ≤ 3 mm]}}
parts: {push: {push: {view: study, campaigns: [push], keys: [name]}}}
)");
    Write("apps/campaigns/push.yaml", "app: tenon-quadruped\nscenario: walk\n");
    Write("apps/scenarios/walk.yaml", "extends: flat\n");
    Write("apps/scenarios/flat.yaml", "speed: 1\n");
    Write("apps/scenarios/other.yaml", "speed: 2\n");
    Write("controllers/legged/gain.cc", "double gain = 2;\n");
    Write("build/apps/tenon-campaign", R"(#!/bin/sh
for last; do :; done
case "$*" in
  *dry-run*) echo "1 points, 3 seeds each, 3 runs" ;;
  *) mkdir -p "$last/run_1" && cp figures "$last/run_1/summary.json" ;;
esac
)");
    fs::permissions(out / "build/apps/tenon-campaign", fs::perms::owner_all);
    Write("figures", R"({"finished": true, "com_error_max_m": 0.002, "wall_s": 1})");
    Write("docs/results.md", "<!-- results push -->\n<!-- end of push -->\n");
    Pretend("out/results/push", "run,name,finished,fell,simulated_s", {"0,A1,true,false,1"});
    stamp =
        Run("-c \"import runpy; tool = runpy.run_path('tools/results'); tool['load'](); "
            "print(tool['sources']('push'), end='')\"");
    Write("out/results/push/stamp.json",
          R"({"commit": "abcdef0", "date": "2026-01-02", "machine": "a machine", "done": true, "seeds": null,
              "duration_s": null, "sources": ")" +
              stamp + "\"}");
    Run("tools/results --report-only");
  }
  std::string Run(const std::string& arguments) {
    const test::Result result = test::RunCommand("cd " + out.string() + " && python3 -B " + arguments);
    exit_code = result.exit_code;
    return result.text;
  }
  std::string PageOfTree() const { return ReadText(out / "docs/results.md"); }

  std::string stamp;
  int exit_code = 0;
};

TEST_F(StaleResultsTest, ATableIsDueOnceItsSourcesChange) {
  EXPECT_THAT(PageOfTree(), AllOf(HasSubstr("| A1 | yes |"), Not(HasSubstr("Stale"))));
  EXPECT_THAT(Run("tools/results --due"), HasSubstr("current"));

  Write("controllers/legged/gain.cc", "double gain =\n    2;  // a comment\n");
  Write("apps/scenarios/other.yaml", "speed: 3\n");
  EXPECT_THAT(Run("tools/results --due"), HasSubstr("current"))
      << "neither comments nor scenarios that no run uses count";

  for (const auto& [file, changed] : {std::pair{"controllers/legged/gain.cc", "double gain = 3;\n"},
                                      {"apps/scenarios/flat.yaml", "speed: 4\n"}}) {
    const std::string before = ReadText(out / file);
    Write(file, changed);
    EXPECT_THAT(Run("tools/results --due"), HasSubstr("due")) << file;
    Write(file, before);
  }
}

TEST_F(StaleResultsTest, ATableIsStaleOnceAFigureOfItsSampleChanges) {
  const std::string build = " --build build";
  Run("tools/results --record" + build);
  ASSERT_EQ(exit_code, 0);

  // Wall-clock times and new figures do not count, nor do sources that change no figure.
  Write("figures", R"({"finished": true, "com_error_max_m": 0.002, "wall_s": 2, "new": 3})");
  Write("controllers/legged/gain.cc", "double gain = 3;\n");
  EXPECT_THAT(Run("tools/results --check" + build), HasSubstr("current"));
  EXPECT_EQ(exit_code, 0);
  Run("tools/results --mark" + build);
  EXPECT_THAT(PageOfTree(), AllOf(HasSubstr("a machine; its sample repeated at "), Not(HasSubstr("Stale"))));
  EXPECT_THAT(Run("tools/results --due"), HasSubstr("current"));

  Write("figures", R"({"finished": true, "com_error_max_m": 0.0020000000000000005, "wall_s": 2})");
  EXPECT_THAT(Run("tools/results --check" + build),
              HasSubstrs("push --replay 1: com_error_max_m was 0.002 and is 0.0020000000000000005",
                         "stale, but the page does not say so"));
  EXPECT_EQ(exit_code, 1);
  Write("controllers/legged/gain.cc", "double gain = 4;\n");
  Run("tools/results --mark" + build);
  EXPECT_THAT(PageOfTree(), HasSubstr("**Stale**: "));
  Run("tools/results --check" + build);
  EXPECT_EQ(exit_code, 0) << "the page says so";

  Write("figures", R"({"finished": true, "com_error_max_m": 0.002})");
  Run("tools/results --check" + build);
  EXPECT_EQ(exit_code, 1) << "the mark is wrong now";
  Run("tools/results --mark" + build);
  EXPECT_THAT(PageOfTree(), Not(HasSubstr("Stale")));
}

TEST_F(StaleResultsTest, RefusesADamagedPage) {
  const std::string page = PageOfTree();
  for (const auto& [damaged, named] :
       {std::pair{std::string("no table"), "'push'"},
        {page + page, "'push' is there 2 times"},
        {page + "<!-- results more -->\n", "'more'"},
        {page.substr(0, page.find('*')) + page.substr(page.find("\n\n") + 2), "stamp"}}) {
    Write("docs/results.md", damaged);
    EXPECT_THAT(Run("tools/results --due"), HasSubstr(named));
    EXPECT_EQ(exit_code, 2) << named;
  }
}

TEST_F(ResultsTest, RefusesBadUsage) {
  EXPECT_EQ(RunResults("--part A44"), 2);
  EXPECT_THAT(text, HasSubstr("observers"));
  EXPECT_EQ(RunResults("--seeds 0"), 2);
  EXPECT_THAT(text, HasSubstr("--seeds"));
}

}  // namespace tenon::results_test
