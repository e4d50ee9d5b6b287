// Runs the binary as its users do.

#include <tenon/tests/apps/run_app.h>

#include <nlohmann/json.hpp>

#include <cmath>

namespace tenon::tenon_observer_order_test {
namespace {

using test::BadUsage;
using test::Read;
using test::Result;
using test::RunCommand;
using ::testing::AllOf;
using ::testing::HasSubstr;

Result RunApp(const std::string& arguments) {
  return RunCommand(std::string(TENON_OBSERVER_ORDER) + " " + arguments);
}

using TenonObserverOrderTest = test::AppTest;

// All that A0 has to show. The settling times of first and second order have closed forms.
TEST_F(TenonObserverOrderTest, ComparesTheOrders) {
  const Result result = RunApp("A0" + Out());
  ASSERT_EQ(result.exit_code, 0) << result.text;
  EXPECT_THAT(result.text, AllOf(HasSubstr("settling ms"), HasSubstr("refused: unstable")));
  const auto summary = nlohmann::json::parse(Read(out / "summary.json"));

  const auto& first = summary["order_1"];
  EXPECT_NEAR(first["settling_time_s"].get<double>(), std::log(50) / 100, 1.5e-3);
  EXPECT_LT(first["overshoot_ratio"].get<double>(), 4e-3);
  EXPECT_NEAR(first["noise_bandwidth_Hz"].get<double>(), 25, 1e-9);
  for (int order = 2; order <= 5; ++order) {
    const auto& variant = summary["order_" + std::to_string(order)];
    EXPECT_EQ(variant["order"].get<double>(), order);
    EXPECT_NEAR(variant["noise_bandwidth_Hz"].get<double>(), 25, 0.01);
    EXPECT_GT(variant["overshoot_ratio"].get<double>(), 0.03);
  }
  // Of second order exp(-pi zeta / sqrt(1 - zeta^2)) with zeta = sqrt(1/2).
  EXPECT_NEAR(summary["order_2"]["overshoot_ratio"].get<double>(), std::exp(-M_PI), 4e-3);

  const auto& corrected = summary["thesis_corrected"];
  EXPECT_NEAR(corrected["settling_time_s"].get<double>(), 1.038, 0.03);
  EXPECT_EQ(corrected["finished"], true);
  const auto& printed = summary["thesis_printed"];
  EXPECT_EQ(printed["stable"], "no");
  EXPECT_EQ(printed["finished"], false);
  EXPECT_THAT(printed["end_reason"].get<std::string>(),
              AllOf(HasSubstr("refused"), HasSubstr("2.01 ± 5.95i, -6.28")));
  EXPECT_EQ(summary["default"]["on_front"], "yes");

  EXPECT_THAT(Read(out / "default" / "signals.csv"),
              HasSubstr("observer.estimate.foot_force.front_left.x [N]"));
  EXPECT_THAT(Read(out / "default" / "scenario.yaml"), HasSubstr("gains_per_s"));
  EXPECT_THAT(Read(out / "thesis_printed" / "summary.json"), HasSubstr("diverges"));
  EXPECT_THAT(Read(out / "report.html"), AllOf(HasSubstr("<title>A0: "), HasSubstr("thesis_corrected")));
  EXPECT_THAT(Read(out / "scenario.yaml"), HasSubstr("order_5"));
}

using TenonObserverOrderUsageTest = test::UsageTest;

TEST_P(TenonObserverOrderUsageTest, IsExitCode2WithAMessage) {
  ExpectExitCode2WithItsMessage(TENON_OBSERVER_ORDER);
}

INSTANTIATE_TEST_SUITE_P(
    All, TenonObserverOrderUsageTest,
    ::testing::Values(BadUsage{"", "no scenario given"}, BadUsage{"A00", "did you mean 'A0'?"},
                      BadUsage{"A0 --set app=tenon-cdpr", "is a scenario of another app"},
                      BadUsage{"A0 --set start_s=3", "start_s = 3"},
                      BadUsage{"A0 --set force_N=[0,0,0]", "force_N"},
                      BadUsage{"A0 --set variants=[]", "variants"},
                      BadUsage{"A0 --set 'variants=[{name: a, gains_per_s: [1], butterworth: {order: 1, "
                               "bandwidth_rad_per_s: 1}}]'",
                               "variant 'a'"},
                      BadUsage{"A0 --set 'variants=[{name: a/b, gains_per_s: [1]}]'",
                               "'a/b' cannot name a directory below --out"},
                      BadUsage{"A0 --set 'variants=[{name: \"a\\0b\", gains_per_s: [1]}]'",
                               "'a\\x00b' cannot name a directory below --out"},
                      BadUsage{"A0 --set 'variants=[{name: summary.json, gains_per_s: [1]}]'",
                               "'summary.json' has the name of an output file"},
                      BadUsage{
                          "A0 --set 'variants=[{name: a, gains_per_s: [1]}, {name: a, gains_per_s: [2]}]'",
                          "two variants have the name 'a'"},
                      BadUsage{"A0 --set \"variants=[{name: $(printf '%0300d' 0), gains_per_s: [1]}]\"",
                               "cannot name a directory below --out"},
                      BadUsage{"A0 --set 'variants=[{name: a, gains_per_s: [-1]}]'",
                               "variants.0: with the gains -1 the estimate diverges"},
                      BadUsage{"A0 --set robot=dogbt", "did you mean 'dogbot'"}));

TEST(TenonObserverOrderListTest, ListsScenariosWithTheirDescriptions) {
  const Result result = RunApp("--list");
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.text, HasSubstr("order and gains of the leg observer"));
}

}  // namespace
}  // namespace tenon::tenon_observer_order_test
