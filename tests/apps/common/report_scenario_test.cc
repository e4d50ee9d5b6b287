#include <tenon/apps/common/report_scenario.h>
#include <tenon/apps/common/scenario_file.h>
#include <tenon/systems/simulation.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace tenon::apps::report_scenario_test {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

struct Opaque {
  int* pointer = nullptr;
};

/// A cart at the end of a spring, x'' = -x.
class Cart final : public LeafSystem<void> {
 public:
  ContinuousState<Vec<2>> x{this, {"x", "m, m/s", "position, velocity"}};
  OutputPort<Vec<2>> state{this, x};
  OutputPort<double> force{this, {"force", "N"}, Uses(x), [](const Vec<2>& x) { return -x[0]; }};
  OutputPort<std::string> label{this, {"label"}, Uses(), [] { return std::string("cart"); }};
  OutputPort<Opaque> opaque{this, {"opaque"}, Uses(), [] { return Opaque(); }};
  OutputPort<Eigen::VectorXd> any{
      this, {"any"}, Uses(), [](Eigen::VectorXd* value) { *value = Eigen::VectorXd::Ones(2); }};
  TimeDerivative<Vec<2>> dx{x, Uses(x), [](const Vec<2>& x) { return Vec<2>(x[1], -x[0]); }};
};
class Pair final : public Subdiagram {
 public:
  Cart& front = Add<Cart>("front");
  Cart& rear = Add<Cart>("rear");
};

class LogScenarioTest : public ::testing::Test {
 protected:
  /// The message of the KeyError that is expected.
  std::string Refusal(const ReportScenario& report, const LogScenario& log, const std::string& key) {
    std::vector<const Source*> signals;
    try {
      AddRequested(*diagram_, report, log, signals);
    } catch (const KeyError& error) {
      EXPECT_EQ(error.key(), key);
      return error.what();
    }
    ADD_FAILURE() << "not refused: " << key;
    return "";
  }
  DiagramBuilder builder_;
  Pair& pair_ = builder_.Add<Pair>("pair");
  std::shared_ptr<const Diagram> diagram_ = builder_.Build();
};

TEST_F(LogScenarioTest, AddsWhatIsNotLogged) {
  ReportScenario report;
  report.plots = {{.title = "front",
                   .signals = {"pair.front.x.velocity", "pair.front.force"},
                   .references = {"pair.rear.x", "pair.rear.x.position"}}};
  report.events = {"pair.rear.force"};
  report.bands = {{.signal = "pair.front.force", .names = {"none"}}};
  std::vector<const Source*> signals{&pair_.front.force};
  AddRequested(*diagram_, report, {.signals = {"pair.rear.any.1", "pair.rear.any"}}, signals);
  EXPECT_THAT(signals, ElementsAre(&pair_.front.force, &pair_.rear.any, &pair_.front.state, &pair_.rear.state,
                                   &pair_.rear.force));
  Simulator simulator(diagram_);
  const auto log = simulator.AddLog(Hz(10), signals);
  simulator.RunTo(0.1);
  EXPECT_EQ(log->column("pair.rear.any.1").back(), 1);
}

TEST_F(LogScenarioTest, NamesTheNearestPortsAndElements) {
  EXPECT_THAT(Refusal({}, {.signals = {"pair.front.force", "pair.frnt.force"}}, "log.signals.1"),
              AllOf(HasSubstr("'pair.frnt.force'"), HasSubstr("'pair.front.force'")));
  EXPECT_THAT(Refusal({}, {.signals = {"pair.rear.x.velocty"}}, "log.signals.0"),
              AllOf(HasSubstr("did you mean 'pair.rear.x.velocity'")));
  ReportScenario report;
  report.plots = {{.title = "a", .signals = {"pair.rear.x"}, .references = {"pair.rear"}}};
  EXPECT_THAT(Refusal(report, {}, "report.plots.0.references.0"), HasSubstr("'pair.rear.x'"));
  report.plots[0].references = {"pair.rear.x", "force"};
  EXPECT_THAT(Refusal(report, {}, "report.plots.0.references.1"), HasSubstr("'pair.rear.force'"));
  report.plots = {};
  report.events = {"pair.rear.forces"};
  EXPECT_THAT(Refusal(report, {}, "report.events.0"), HasSubstr("'pair.rear.force'"));
  report.events = {};
  report.bands = {{.signal = "pair.rear.mode", .names = {"none"}}};
  EXPECT_THAT(Refusal(report, {}, "report.bands.0.signal"), HasSubstr("'pair.rear.mode'"));
}

TEST_F(LogScenarioTest, RefusesPortsWithoutNumbers) {
  EXPECT_THAT(Refusal({}, {.signals = {"pair.rear.label"}}, "log.signals.0"),
              AllOf(HasSubstr("'pair.rear.label'"), HasSubstr("std::string")));
  EXPECT_THAT(Refusal({}, {.signals = {"pair.rear.opaque"}}, "log.signals.0"), HasSubstr("Opaque"));
}

TEST_F(LogScenarioTest, LimitsTheNumberOfSignals) {
  EXPECT_THROW(LogScenario{std::vector<std::string>(1001)}.Validate(), ParameterError);
}

}  // namespace tenon::apps::report_scenario_test
