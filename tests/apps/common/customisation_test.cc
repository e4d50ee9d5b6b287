// Apps with blocks of a user's own, called as the main function of a user's program calls them.

#include <tenon/apps/cdpr/cdpr_app.h>
#include <tenon/apps/guide_dog/guide_dog_app.h>
#include <tenon/apps/quadruped/quadruped_app.h>
#include <tenon/tests/apps/run_app.h>

#include <nlohmann/json.hpp>

#include <iterator>

namespace tenon::customisation_test {
namespace {

using apps::CdprApp;
using apps::GuideDogApp;
using apps::Outputs;
using apps::QuadrupedApp;
using apps::Tally;
using test::Read;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

struct Keys {
  double gain_per_s = 30;
  static FieldList Fields() { return {{"gain_per_s", &Keys::gain_per_s}}; }
  void Validate() const { Demand(gain_per_s > 0, "gain_per_s must be positive"); }
};

class CustomisationTest : public test::AppTest {
 protected:
  /// Runs an app with the scenario and options, and returns its exit code.
  int RunIn(const std::string& name, const auto& app, std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "my_app");
    arguments.insert(arguments.end(), {"--out", (out / name).string()});
    std::vector<char*> words;
    for (std::string& argument : arguments) words.push_back(argument.data());
    ::testing::internal::CaptureStdout();
    ::testing::internal::CaptureStderr();
    const int code = app.Run(static_cast<int>(words.size()), words.data());
    text_ = ::testing::internal::GetCapturedStdout() + ::testing::internal::GetCapturedStderr();
    return code;
  }
  nlohmann::json SummaryOf(const std::string& name) const {
    return nlohmann::json::parse(Read(out / name / "summary.json"));
  }
  mutable std::string text_;  // stdout and stderr of the last run
};

const std::vector<std::string> kShort{"A1", "--duration", "0.1", "--set", "walk.judged_from_s=0"};

std::vector<std::string> With(std::vector<std::string> arguments, const std::vector<std::string>& more) {
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

TEST_F(CustomisationTest, TheShippedObserverThroughTheHookGivesTheSameRun) {
  QuadrupedApp same;
  same.Customise([](DiagramBuilder& builder, QuadrupedWalk& walk) {
    const ComObserverParams params = walk.observer.com->params;
    builder.Replace<ComObserver>(*walk.observer.com, params);
  });
  ASSERT_EQ(RunIn("same", same, kShort), 0) << text_;
  ASSERT_EQ(RunIn("shipped", QuadrupedApp(), kShort), 0) << text_;
  EXPECT_EQ(Read(out / "same/signals.csv"), Read(out / "shipped/signals.csv"));
  EXPECT_EQ(SummaryOf("same")["com_error_max_m"], SummaryOf("shipped")["com_error_max_m"]);
}

/// An app whose observer estimates a constant force of `gain_per_s` N, and shows it.
QuadrupedApp AppOfGain() {
  QuadrupedApp app;
  app.Customise<Keys>([](DiagramBuilder& builder, QuadrupedWalk& walk, const Keys& keys, Outputs& outputs) {
    auto& guess = builder.AddFunction({"guess", "N"}, Uses(builder.time),
                                      [gain = keys.gain_per_s](double time) { return gain * time; });
    auto& trunk = builder.AddFunction({"trunk", "m"}, Uses(walk.world.plant.state),
                                      [](const LeggedState& x) { return x.p_WB; });
    auto& up = builder.AddFunction({"up", "N"}, Uses(guess), [](double f) { return Vec<3>(0, 0, f); });
    outputs.Arrow("the guess", ShapeRole::kEstimate, trunk, up, 0.01);
    outputs.Plot("the guess", {&guess});
    outputs.Figure("guess_max_N", guess, &Tally::max);
    outputs.Figure("guess_late_min_N", guess, &Tally::min, 0.05);
  });
  return app;
}

TEST_F(CustomisationTest, HasKeysSignalsPlotsAndFiguresOfItsOwn) {
  ASSERT_EQ(RunIn("run", AppOfGain(), With(kShort, {"--set", "custom.gain_per_s=40"})), 0) << text_;
  EXPECT_NEAR(SummaryOf("run")["guess_max_N"], 4, 1e-9);
  EXPECT_NEAR(SummaryOf("run")["guess_late_min_N"], 2, 1e-9);
  EXPECT_NEAR(test::Column(out / "run", "guess.output [N]").back(), 4, 1e-9);
  EXPECT_THAT(Read(out / "run/report.html"),
              AllOf(HasSubstr("\"title\":\"the guess\""), HasSubstr("\"name\":\"the guess\"")));
  EXPECT_THAT(Read(out / "run/scenario.yaml"), HasSubstr("gain_per_s: 40"));
  // The written scenario repeats the run, and has the defaults of the customisation filled in.
  ASSERT_EQ(RunIn("again", AppOfGain(), {(out / "run/scenario.yaml").string(), "--duration", "0.1"}), 0);
  EXPECT_EQ(Read(out / "again/signals.csv"), Read(out / "run/signals.csv"));
  ASSERT_EQ(RunIn("default", AppOfGain(), kShort), 0) << text_;
  EXPECT_THAT(Read(out / "default/scenario.yaml"), HasSubstr("gain_per_s: 30"));
}

TEST_F(CustomisationTest, ListsAndChecksItsKeys) {
  ASSERT_EQ(RunIn("keys", AppOfGain(), {"--keys"}), 0);
  EXPECT_THAT(text_, AllOf(HasSubstr("custom.gain_per_s"), HasSubstr("1/s"), HasSubstr("profile")));
  EXPECT_EQ(RunIn("no", AppOfGain(), With(kShort, {"--set", "custom.gain=1"})), 2);
  EXPECT_THAT(text_, AllOf(HasSubstr("my_app: "), HasSubstr("custom.gain"), HasSubstr("gain_per_s")));
  EXPECT_EQ(RunIn("no", AppOfGain(), With(kShort, {"--set", "custom.gain_per_s=-1"})), 2);
  EXPECT_THAT(text_, HasSubstr("--set custom.gain_per_s=-1: custom.gain_per_s: "));
  const std::string file = Write("a.yaml", "extends: A1\ncase: a\ncustom:\n  gain_per_s: 3\n  gein: 4\n");
  EXPECT_EQ(RunIn("no", AppOfGain(), {file}), 2);
  EXPECT_THAT(text_, HasSubstr("a.yaml:5:3: custom.gein"));
  // Neither a shipped app nor a robot that stands has such keys.
  EXPECT_EQ(RunIn("no", QuadrupedApp(), With(kShort, {"--set", "custom.gain_per_s=1"})), 2);
  EXPECT_THAT(text_, HasSubstr("custom"));
  EXPECT_EQ(RunIn("no", AppOfGain(), {"stand"}), 2);
  EXPECT_THAT(text_, HasSubstr("walks"));
}

/// A supervisor that lets every command pass.
class NoSupervisor final : public LeafSystem<void> {
 public:
  InputPort<WalkCommand> command{this, {"command"}};
  OutputPort<GuideStatus> status{this, {"status"}, Uses(), [] { return GuideStatus(); }};
  OutputPort<WalkCommand> walk{this, {"walk"}, Uses(command), [](const WalkCommand& c) { return c; }};
};

TEST_F(CustomisationTest, ErrorsOfTheHookNameTheKeyCustom) {
  QuadrupedApp app;
  app.Customise([](DiagramBuilder& builder, QuadrupedWalk&) { builder.Add<NoSupervisor>("a.b"); });
  EXPECT_NE(RunIn("no", app, kShort), 0);
  EXPECT_THAT(text_, HasSubstr("a.b"));
}

TEST_F(CustomisationTest, IsComparedWithTheShippedOnes) {
  ASSERT_EQ(RunIn("all", AppOfGain(), With(kShort, {"--set", "compare=[none]", "--compare"})), 0) << text_;
  const nlohmann::json summary = SummaryOf("all");
  EXPECT_EQ(summary["none"]["observer"], "none");
  EXPECT_FALSE(summary["none"].contains("guess_max_N"));
  EXPECT_TRUE(summary["mine"].contains("guess_max_N"));
  EXPECT_THAT(Read(out / "all/summary.json"), StartsWith("{\n  \"mine\"")) << "the page opens with it";
  ASSERT_EQ(RunIn("cables", CdprApp().Customise([](DiagramBuilder&, CdprLoop&) {}),
                  {"D1", "--duration", "0.02", "--compare"}),
            0)
      << text_;
  EXPECT_TRUE(SummaryOf("cables").contains("mine"));
  EXPECT_THAT(Read(out / "cables/summary.json"), StartsWith("{\n  \"mine\""));
}

TEST_F(CustomisationTest, ReplacesTheSupervisorOfAGuideDogAndTheControllerOfACableRobot) {
  GuideDogApp dog;
  dog.Customise(
      [](DiagramBuilder& builder, GuideDog& dog) { builder.Replace<NoSupervisor>(dog.supervisor); });
  EXPECT_EQ(RunIn("dog", dog, {"C1", "--duration", "0.1", "--set", "walk.judged_from_s=0"}), 0) << text_;
  CdprApp cables;
  cables.Customise<Keys>([](DiagramBuilder& builder, CdprLoop& loop, const Keys& keys) {
    CablePdParams params = loop.control.pd->params;
    params.damping_N_s_per_m *= keys.gain_per_s / 30;
    builder.Replace<CablePd>(*loop.control.pd, params);
  });
  const std::vector<std::string> pd{"D1", "--duration", "0.1", "--set", "controller=pd"};
  ASSERT_EQ(RunIn("cables", cables, pd), 0) << text_;
  ASSERT_EQ(RunIn("shipped", CdprApp(), pd), 0) << text_;
  EXPECT_EQ(Read(out / "cables/signals.csv"), Read(out / "shipped/signals.csv"));
  ASSERT_EQ(RunIn("cables", cables, With(pd, {"--set", "custom.gain_per_s=60"})), 0) << text_;
  EXPECT_NE(Read(out / "cables/signals.csv"), Read(out / "shipped/signals.csv"));
}

// The tutorial's program in a campaign, which runs it in one process per run.
TEST_F(CustomisationTest, CampaignsRunIt) {
  const std::string file =
      Write("bandwidth.yaml", std::string("app: ") + MY_OBSERVER +
                                  "\nscenario: A1\nduration_s: 0.1\n"
                                  "set: {walk.judged_from_s: 0}\n"
                                  "vary: {custom.bandwidth_rad_per_s: {grid: [5, 50]}}\n");
  const test::Result result = test::RunCommand(std::string(TENON_CAMPAIGN) + " " + file + " --jobs 1 --out " +
                                               (out / "runs").string());
  ASSERT_EQ(result.exit_code, 0) << result.text;
  EXPECT_THAT(Read(out / "runs/runs.csv"), HasSubstr(",dogbot,mine,"));
  EXPECT_THAT(Read(out / "runs/runs.csv"),
              AllOf(HasSubstr("custom.bandwidth_rad_per_s"), HasSubstr("\n0,1,5,A1,true,false,"),
                    HasSubstr("\n1,1,50,A1,true,false,")));
}

}  // namespace
}  // namespace tenon::customisation_test
