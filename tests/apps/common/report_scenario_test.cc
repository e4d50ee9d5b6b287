#include <tenon/apps/common/columns.h>
#include <tenon/apps/common/report_scenario.h>
#include <tenon/systems/simulation.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::apps::report_scenario_test {

using ::testing::AllOf, ::testing::ElementsAre, ::testing::HasSubstr, ::testing::IsEmpty;

struct Opaque {
  int* pointer = nullptr;
};

/// A cart at the end of a spring, x'' = -x.
struct Cart final : LeafSystem<void> {
  ContinuousState<Vec<2>> x{this, {"x", "m, m/s", "position, velocity"}};
  OutputPort<Vec<2>> state{this, x};
  OutputPort<double> force{this, {"force", "N"}, Uses(x), [](const Vec<2>& x) { return -x[0]; }};
  OutputPort<std::string> label{this, {"label"}, Uses(), [] { return std::string("cart"); }};
  OutputPort<Opaque> opaque{this, {"opaque"}, Uses(), [] { return Opaque(); }};
  OutputPort<Eigen::VectorXd> any{
      this, {"any"}, Uses(), [](Eigen::VectorXd* value) { *value = Eigen::VectorXd::Ones(2); }};
  TimeDerivative<Vec<2>> dx{x, Uses(x), [](const Vec<2>& x) { return Vec<2>(x[1], -x[0]); }};
};
struct Pair final : Subdiagram {
  Cart& front = Add<Cart>("front");
  Cart& rear = Add<Cart>("rear");
};

struct LogScenarioTest : ::testing::Test {
  /// The message of the KeyError that is expected.
  std::string Refusal(const ReportScenario& report, const LogScenario& log, const std::string& key) {
    std::vector<const Source*> signals;
    try {
      AddRequested(*diagram_, {.report = report, .log = log}, signals);
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
                   .signals = {"norm:pair.front.x", "rate:pair.front.force"},
                   .references = {"xy:pair.rear.x", "pair.rear.x.position"}}};
  report.events = {"pair.rear.force"};
  report.bands = {{.signal = "pair.front.force", .names = {"none"}}};
  std::vector<const Source*> signals{&pair_.front.force};
  AddRequested(*diagram_, {.report = report, .log = {{"pair.rear.any.1", "pair.rear.any"}}}, signals);
  EXPECT_THAT(signals, ElementsAre(&pair_.front.force, &pair_.rear.any, &pair_.front.state, &pair_.rear.state,
                                   &pair_.rear.force));
  Simulator simulator(diagram_);
  const auto log = simulator.AddLog(Hz(10), signals);
  simulator.RunTo(0.1);
  EXPECT_EQ(log->column("pair.rear.any.1").back(), 1);
}

TEST_F(LogScenarioTest, NamesTheNearestPortsAndElements) {
  EXPECT_THAT(Refusal({}, {.signals = {"pair.front.force", "pair.frnt.force"}}, "log.signals.1"),
              HasSubstrs("'pair.frnt.force'", "'pair.front.force'"));
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
              HasSubstrs("'pair.rear.label'", "std::string"));
  EXPECT_THAT(Refusal({}, {.signals = {"pair.rear.opaque"}}, "log.signals.0"), HasSubstr("Opaque"));
}

TEST_F(LogScenarioTest, LimitsTheNumberOfSignals) {
  EXPECT_THROW(LogScenario{std::vector<std::string>(1001)}.Validate(), ParameterError);
}

struct Leg {
  Vec<2> p = Vec<2>::Zero();
  double force = 0;
  static FieldList Fields() { return {{"p", &Leg::p}, {"force", &Leg::force, "N"}}; }
};
struct Robot {
  Leg first;
  std::array<Leg, 2> legs;
  Eigen::VectorXd cables = Eigen::VectorXd::Zero(2);
  double hidden = 0;
  static FieldList Fields() {
    return {{"first", &Robot::first},
            {"legs", &Robot::legs, "", "left, right"},
            {"cables", &Robot::cables},
            Undescribed(&Robot::hidden)};
  }
};

struct Legs final : LeafSystem<void> {
  OutputPort<double> forces{this, {"forces"}, Uses(), [] { return 0.0; }};
  OutputPort<double> force{this, {"force"}, Uses(), [] { return 0.0; }};
  OutputPort<Robot> robot{this, {"robot"}, Uses(), [] { return Robot(); }};
  OutputPort<std::array<Vec<2>, 2>> pair{this, {"pair", "m", "a, b"}, Uses(), [] {
                                           return std::array{Vec<2>(1, 2), Vec<2>(3, 4)};
                                         }};
  OutputPort<std::vector<Leg>> list{this, {"list"}, Uses(), [] { return std::vector<Leg>(3); }};
};

/// Lacks all ports but one.
struct Other final : LeafSystem<void> {
  OutputPort<double> force{this, {"force"}, Uses(), [] { return 0.0; }};
};

/// The names of a log.
struct Names final : LogSink {
  std::vector<std::string> names;
  void Begin(const std::vector<std::string>& all, const std::vector<std::string>&) override { names = all; }
  void Row(std::span<const double>) override {}
};

struct ColumnsTest : ::testing::Test {
  /// The names in a log of the signals of the built diagram.
  std::vector<std::string> Log(const std::vector<const Source*>& signals) {
    diagram_ = builder_.Build();
    Simulator simulator(diagram_);
    const auto sink = std::make_shared<Names>();
    simulator.AddLog(Hz(10), signals, {sink});
    simulator.RunTo(0.1);
    return sink->names;
  }
  DiagramBuilder builder_;
  std::shared_ptr<const Diagram> diagram_;  // owns the blocks
  Legs& block_ = builder_.Add<Legs>("block");
};

TEST_F(ColumnsTest, FollowMembersAndItems) {
  const auto names = Log({&block_.forces, &block_.force, &block_.robot, &block_.pair, &block_.list});
  const auto found = [&](const auto&... steps) {
    std::vector<std::string> in_log;
    for (const std::size_t column : Columns(names, steps...)) in_log.push_back(names[column]);
    return in_log;
  };
  EXPECT_THAT(found(block_.force), ElementsAre("block.force"));
  EXPECT_THAT(found(block_.robot, &Robot::first, &Leg::p),
              ElementsAre("block.robot.first.p.0", "block.robot.first.p.1"));
  EXPECT_THAT(found(block_.robot, &Robot::legs, 1, &Leg::force), ElementsAre("block.robot.legs.right.force"));
  EXPECT_THAT(found(block_.robot, &Robot::cables),
              ElementsAre("block.robot.cables.0", "block.robot.cables.1"));
  EXPECT_THAT(found(block_.pair, 1), ElementsAre("block.pair.b.0", "block.pair.b.1"));
  EXPECT_THAT(found(block_.list, 2, &Leg::force), ElementsAre("block.list.2.force"));
  EXPECT_EQ(names[Column(names, block_.force)], "block.force");
  EXPECT_EQ(SignalName(block_.robot, &Robot::legs, 0), "block.robot.legs.left");
}

TEST_F(ColumnsTest, RefuseWhatIsNotLogged) {
  const auto names = Log({&block_.force});
  EXPECT_TRUE(Throws<Error>([&] { Columns(names, block_.robot, &Robot::legs); }, "'block.robot.legs'"));
  EXPECT_TRUE(
      Throws<BuildError>([&] { SignalName(block_.robot, &Robot::hidden); }, "'block.robot'", "Robot"));
}

TEST_F(ColumnsTest, FollowTheBlockThatReplacedAnother) {
  const Other& other = builder_.Replace<Other>(block_);
  EXPECT_EQ(FindCurrent(block_.force), &other.force);
  EXPECT_EQ(FindCurrent(block_.robot), nullptr);
  EXPECT_THAT(Present<Source>({&block_.robot, &block_.force}), ElementsAre(&other.force));
  const auto names = Log({&other.force});
  EXPECT_EQ(Column(names, block_.force), 1U);
  EXPECT_TRUE(Throws<BuildError>([&] { Columns(names, block_.robot, &Robot::first); }, "'block.robot'"));
  EXPECT_THAT(Columns(names, FindCurrent(block_.robot), &Robot::first), IsEmpty());
  EXPECT_FALSE(Column(names, FindCurrent(block_.robot), &Robot::first, &Leg::force));
}

}  // namespace tenon::apps::report_scenario_test
