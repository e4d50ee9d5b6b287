// The comparison of orders and gains of the observer.

#include <tenon/tests/apps/run_app.h>

#include <nlohmann/json.hpp>

#include <cmath>

namespace tenon::tenon_observer_order_test {
namespace {

using test::Read;
using ::testing::AllOf;
using ::testing::HasSubstr;

class TenonObserverOrderTest : public test::AppTest {
 protected:
  TenonObserverOrderTest() : AppTest(TENON_OBSERVER_ORDER) {}
};

// The settling time of first order and the overshoot of second order have closed forms.
TEST_F(TenonObserverOrderTest, ComparesTheOrders) {
  EXPECT_THAT(Run("A0"), AllOf(HasSubstr("settling ms"), HasSubstr("refused: unstable")));
  const auto summary = nlohmann::json::parse(Summary());

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
  // The overshoot of second order is exp(-pi zeta / sqrt(1 - zeta^2)) with zeta = sqrt(1/2).
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

// The robot falls before the force begins, which is then not estimated without an overshoot.
TEST_F(TenonObserverOrderTest, WithoutTheForceThereIsNoOvershoot) {
  Run("A0 --set start_s=0.99 pd.stiffness_N_m_per_rad=0.01 pd.gravity_compensation=false "
      "'variants=[{name: a, gains_per_s: [100]}]'",
      3);
  EXPECT_THAT(Summary(), HasSubstr("\"overshoot_ratio\": null"));
}

TEST_F(TenonObserverOrderTest, RefusesBadUsage) {
  ExpectRefused({{"", "no scenario given"},
                 {"A00", "'A0'"},
                 {"A0 --set app=tenon-cdpr", "run tenon-cdpr A0"},
                 {"A0 --set start_s=3", "start_s"},
                 {"A0 --set variants=[]", "variants"}});
  ExpectSettingsRefused("A0", {"force_N=[0,0,0]", "robot=dogbt"});
  const auto variants = [](const std::string& text) { return "A0 --set \"variants=[" + text + "]\""; };
  ExpectRefused({{variants("{name: a, gains_per_s: [1], butterworth: {order: 1, bandwidth_rad_per_s: 1}}"),
                  ": variants.0: "},
                 {variants("{name: a, gains_per_s: [-1]}"), ": variants.0: "},
                 {variants("{name: a/b, gains_per_s: [1]}"), "'a/b'"},
                 {variants("{name: \\\"a\\0b\\\", gains_per_s: [1]}"), "'a\\x00b'"},
                 {variants("{name: $(printf '%0300d' 0), gains_per_s: [1]}"), "'000000"},
                 {variants("{name: summary.json, gains_per_s: [1]}"), "'summary.json'"},
                 {variants("{name: a, gains_per_s: [1]}, {name: a, gains_per_s: [2]}"), "'a'"}});
}

TEST(TenonObserverOrderListTest, ListsScenariosWithTheirDescriptions) {
  EXPECT_THAT(test::RunCommand(TENON_OBSERVER_ORDER " --list").text,
              HasSubstr("order and gains of the leg observer"));
}

}  // namespace
}  // namespace tenon::tenon_observer_order_test
