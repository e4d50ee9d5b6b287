#include <tenon/systems/yaml/yaml.h>
#include <tenon/tests/systems/framework/test_blocks.h>

namespace tenon::range_test {

using ::testing::AllOf, ::testing::HasSubstr, ::testing::StartsWith;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(RangeTest, EndsBelongToItOrNot) {
  EXPECT_TRUE(Range().AtLeast(0).Contains(0));
  EXPECT_FALSE(Range().AtLeast(0).Contains(-1e-300));
  EXPECT_FALSE(Range().Above(0).Contains(0));
  EXPECT_TRUE(Range().Above(0).Contains(1e-300));
  EXPECT_TRUE(Range().AtMost(1).Contains(1));
  EXPECT_FALSE(Range().AtMost(1).Contains(std::nextafter(1, 2)));
  EXPECT_FALSE(Range().Below(1).Contains(1));
  EXPECT_TRUE(Range().Below(1).Contains(std::nextafter(1, 0)));
  for (const double end : {-2., 3.}) EXPECT_TRUE(Range().Between(-2, 3).Contains(end));
  EXPECT_FALSE(Range().Positive().Contains(0));
}

TEST(RangeTest, OnlyGivenInfinitiesAreAllowed) {
  EXPECT_FALSE(Range().Positive().Contains(kInfinity));
  EXPECT_TRUE(Range().Positive().OrInfinite().Contains(kInfinity));
  EXPECT_FALSE(Range().Positive().OrInfinite().Contains(-kInfinity));
  EXPECT_FALSE(Range().Positive().OrInfinite().Contains(0));
  EXPECT_FALSE(Range().Finite().Contains(-kInfinity));
  EXPECT_FALSE(Range().Finite().OrInfinite().Contains(NAN));
  EXPECT_TRUE(Range().Contains(NAN)) << "without a range";
}

TEST(RangeTest, SaysWhatIsAllowed) {
  EXPECT_EQ(Range().Text(), "");
  EXPECT_EQ(Range().Finite().Text(), "");
  EXPECT_EQ(Range().Between(0, 1).Text("m"), "from 0 to 1 m");
  EXPECT_EQ(Range().Above(-1).AtMost(100).Text(), "above -1 and at most 100");
  EXPECT_EQ(Range().AtLeast(0).Below(1).Text(), "at least 0 and below 1");
  EXPECT_EQ(Range().Below(2).Text(), "below 2");
  EXPECT_EQ(Range().Positive().OrInfinite().Text("s"), "above 0 s, or infinite");
}

struct Spring {
  double stiffness = 1;
  Vec<2> anchor = Vec<2>::Zero();
  std::optional<double> limit;
  std::vector<double> knots;
  int turns = 3;
  double preload = 0;
  static FieldList Fields() {
    return {Required("stiffness_N_per_m", &Spring::stiffness).Positive(),
            Field("anchor_m", &Spring::anchor).Between(-1, 1),
            Field("limit_N", &Spring::limit).AtLeast(0).Because("a spring cannot push"),
            Field("knots", &Spring::knots).Below(5),
            Field("turns", &Spring::turns).AtLeast(2),
            {"preload_N", &Spring::preload}};
  }
};
struct Suspension {
  std::array<Spring, 2> springs;
  std::optional<Spring> spare;
  Rate rate = Hz(100);
  static FieldList Fields() {
    return {{"springs", &Suspension::springs}, {"spare", &Suspension::spare}, Undescribed(&Suspension::rate)};
  }
};

std::string ErrorOf(const std::string& text) {
  try {
    YamlDocument::Parse(text, "s.yaml").Read<Suspension>();
  } catch (const ParameterError& error) {
    return error.what();
  }
  return "";
}

TEST(RangeTest, FilesAreRefusedWithPlaceKeyValueAndRange) {
  const std::string begin = "springs:\n  - stiffness_N_per_m: 1\n  - stiffness_N_per_m: 2\n    ";
  for (const auto& [line, place, parts] : std::vector<std::array<std::string, 3>>{
           {"anchor_m: [0, 1.5]", "4:19: springs.1.anchor_m.1: ", "= 1.5 must be from -1 to 1 m"},
           {"limit_N: -2", "4:14: springs.1.limit_N: ", "-2 must be at least 0 N: a spring cannot push"},
           {"knots: [1, 2, 5]", "4:19: springs.1.knots.2: ", "knots.2 = 5 must be below 5"},
           {"turns: 1", "4:12: springs.1.turns: ", "turns = 1 must be at least 2"}})
    EXPECT_THAT(ErrorOf(begin + line), AllOf(StartsWith("s.yaml:" + place), HasSubstr(parts))) << line;
  for (const char* line : {"anchor_m: [-1, 1]", "limit_N: 0", "limit_N: null", "knots: []", "turns: 2"})
    EXPECT_EQ(ErrorOf(begin + line), "") << line;
  EXPECT_THAT(ErrorOf("springs:\n  - stiffness_N_per_m: 0\n  - stiffness_N_per_m: 2\n"),
              StartsWith("s.yaml:2:24: springs.0.stiffness_N_per_m: "));
}

struct Vehicle final : LeafSystem<Suspension> {
  using LeafSystem::LeafSystem;
  Parameter<Spring> spring{this, {"spring"}, params.springs[0], "one of the springs"};
  Parameter<double> stiffness{this, {"stiffness", "N/m"}, params.springs[1].stiffness, "of the other"};
  Parameter<Vec<2>> gain{this, {"gain", "m"}, Vec<2>::Zero(), "no member of params", Range().AtMost(1)};
  Parameter<double> free{this, "free", 0, "without a range"};
};

struct Trailer final : Subdiagram {
  explicit Trailer(const Suspension& suspension) { Add<Vehicle>("axle", suspension); }
};

TEST(RangeTest, BlocksAreRefusedWithBlockAndKey) {
  DiagramBuilder builder;
  Suspension suspension;
  suspension.spare.emplace().limit = -1;
  try {
    builder.Add<Trailer>("trailer", suspension);
    ADD_FAILURE();
  } catch (const ParameterError& error) {
    EXPECT_EQ(error.block(), "trailer.axle");
    EXPECT_THAT(error.what(), HasSubstrs("'axle'", "spare.limit_N = -1"));
  }
  EXPECT_TRUE(Throws<ParameterError>([&] { CheckRanges(suspension, "rear"); }, "rear.spare.limit_N"));
}

TEST(RangeTest, ParametersAreRefused) {
  TestRig<Vehicle> rig;
  const auto refused = [&](auto set, const char* key) {
    try {
      set();
    } catch (const ParameterError& error) {
      EXPECT_EQ(error.block(), "block");
      EXPECT_THAT(error.what(), HasSubstr(key));
      return true;
    }
    return false;
  };
  EXPECT_TRUE(refused([&] { rig.Set(rig->spring, {.stiffness = 0}); }, "spring.stiffness_N_per_m = 0"));
  EXPECT_TRUE(refused([&] { rig.Set(rig->stiffness, 0); }, "stiffness = 0 must be above 0 N/m"));
  EXPECT_TRUE(refused([&] { rig.Set(rig->gain, {0, 1.5}); }, "gain.1 = 1.5 must be at most 1 m"));
  EXPECT_EQ(rig[rig->gain], Vec<2>(0, 0)) << "nothing is changed";
  rig.Set(rig->gain, {-3, 1});
  rig.Set(rig->free, -kInfinity);
}

TEST(RangeTest, ParametersTellTheirRanges) {
  TestRig<Vehicle> rig;
  const std::vector<Range> spring = rig->spring.ranges();
  ASSERT_EQ(spring.size(), 5U) << "stiffness, two of anchor, turns, preload";
  EXPECT_EQ(spring[0].low(), 0);
  EXPECT_TRUE(spring[0].low_open());
  EXPECT_EQ(spring[2].high(), 1);
  EXPECT_FALSE(spring[2].high_open());
  EXPECT_EQ(spring[3].low(), 2);
  EXPECT_TRUE(spring[4].any());
  EXPECT_EQ(rig->stiffness.ranges()[0].low(), 0) << "of the member of params";
  EXPECT_EQ(rig->gain.ranges()[1].high(), 1);
  EXPECT_TRUE(rig->free.range().any());
}

struct Broken final : LeafSystem<void> {
  OutputPort<double> y{this, "y", Uses(), []() -> double { throw std::runtime_error("broken"); }};
};

TEST(RangeTest, RunErrorsTellTheirBlock) {
  DiagramBuilder builder;
  const auto& broken = builder.Add<Broken>("pump");
  const auto context = builder.Build()->CreateContext();
  try {
    context->Eval(broken.y);
    ADD_FAILURE();
  } catch (const RunError& error) {
    EXPECT_EQ(error.block(), "pump");
  }
}

/// Limits of the force of Servo.
struct Limits {
  double low = -5, high = 5;
  static FieldList Fields() { return {{"low", &Limits::low, "N"}, {"high", &Limits::high, "N"}}; }
};
struct ServoParams {
  double kp = 10;      // N/m
  Limits limits = {};  // N
  Rate rate = Hz(100);
  void Validate() const {
    Demand(kp > 0, "kp must be positive");
    Demand(limits.low < limits.high, "limits.low must be below limits.high");
  }
};
struct Servo final : LeafSystem<ServoParams> {
  using LeafSystem::LeafSystem;
  InputPort<Vec<2>> x{this, {"x", "m, m/s"}};
  Parameter<double> kp{this, {"kp", "N/m"}, params.kp, "stiffness"};
  Parameter<double> low{this, {"low", "N"}, params.limits.low};
  Parameter<double> high{this, {"high", "N"}, params.limits.high};
  Parameter<double> kd{this, {"kd", "N s/m"}, 2.0, "damping, no member of params"};
  OutputPort<double> u{this,
                       {"u", "N"},
                       Sampled{params.rate},
                       Uses(x, kp, kd, low, high),
                       [](const Vec<2>& x, double kp, double kd, double low, double high) {
                         return std::min(std::max(-kp * x[0] - kd * x[1], low), high);
                       }};
};
struct Bounded final : LeafSystem<Limits> {
  using LeafSystem::LeafSystem;
  Parameter<Limits> limits{this, {"limits"}, params};
  OutputPort<double> width{
      this, {"width", "N"}, Uses(limits), [](const Limits& l) { return l.high - l.low; }};
};

struct Loop {
  DiagramBuilder builder;
  Servo* servo;
  Cart* cart;
  explicit Loop(const ServoParams& params = {})
      : servo(&builder.Add<Servo>("servo", params)), cart(&builder.Add<Cart>("cart")) {
    builder.Connect(cart->state, servo->x);
    builder.Connect(servo->u, cart->force);
  }
};

TEST(ParameterTest, ChangesInTheMiddleOfARun) {
  Loop loop;
  Simulator simulator(loop.builder.Build());
  simulator.context().Set(loop.cart->x, {0.1, 0});
  simulator.RunTo(0.005);
  EXPECT_EQ(simulator.context().Eval(loop.servo->u), -1);
  simulator.context().Set(loop.servo->kp, 20);
  EXPECT_EQ(simulator.context().Eval(loop.servo->u), -1) << "held until its tick";
  simulator.RunTo(0.01);
  EXPECT_NEAR(simulator.context().Eval(loop.servo->u), -2, 0.02);
}

TEST(ParameterTest, SettingRunsValidateWithAllPresentValues) {
  TestRig<Servo> rig;
  EXPECT_TRUE(Throws<ParameterError>([&] { rig.Set(rig->kp, -1); }, "'block.kp'"));
  EXPECT_EQ(rig[rig->kp], 10) << "nothing is changed";
  rig.Set(rig->high, 2);
  EXPECT_TRUE(Throws<ParameterError>([&] { rig.Set(rig->low, 3); }, "'block.low'", "limits.low"));
  rig.Set(rig->low, 1);
  EXPECT_TRUE(Throws<ParameterError>([&] { rig.Set(rig->kd, std::numeric_limits<double>::quiet_NaN()); },
                                     "'block.kd'", "NaN"));
}

TEST(ParameterTest, SeveralAreSetAtOnce) {
  TestRig<Servo> rig;
  rig.context().Set(rig->low, 6, rig->high, 8.0);
  EXPECT_EQ(rig[rig->low], 6);
  EXPECT_EQ(rig[rig->high], 8);
  EXPECT_TRUE(Throws<ParameterError>([&] { rig.context().Set(rig->high, 1, rig->low, 2); }, "limits.low"));
  EXPECT_EQ(rig[rig->high], 8) << "nothing is changed";
}

TEST(ParameterTest, IsListedWithUnitAndDescription) {
  Loop loop;
  const auto diagram = loop.builder.Build();
  const auto parameters = diagram->parameters();
  ASSERT_EQ(parameters.size(), 4u);
  EXPECT_EQ(parameters[0]->path(), "servo.kp");
  EXPECT_EQ(parameters[0]->elements()[0].unit, "N/m");
  EXPECT_EQ(parameters[0]->description(), "stiffness");
  EXPECT_EQ(parameters[0]->initial_numbers(), std::vector<double>{10});
  auto context = diagram->CreateContext();
  context->SetDoubles(*parameters[0], std::vector<double>{4});
  EXPECT_EQ(context->Eval(loop.servo->kp), 4);
  EXPECT_TRUE(
      Throws<ParameterError>([&] { context->SetDoubles(*parameters[0], std::vector<double>{-4}); }, "kp"));
}

TEST(ParameterTest, StructsAreSetAsAWhole) {
  TestRig<Bounded> rig;
  EXPECT_EQ(rig[rig->width], 10);
  rig.Set(rig->limits, {.low = 1, .high = 4});
  EXPECT_EQ(rig[rig->width], 3);
}

/// y = exp(rate) u, the factor computed once for each rate.
struct Amplifier final : LeafSystem<void> {
  InputPort<double> u{this, {"u"}};
  Parameter<double> rate{this, {"rate"}, 0.0};
  Shared<double> factor{this, "factor", Uses(rate), &Amplifier::CalcFactor};
  OutputPort<double> y{
      this, {"y"}, Sampled{Hz(10)}, Uses(factor, u), [](double factor, double u) { return factor * u; }};
  mutable int count = 0;

 private:
  double CalcFactor(double rate) const {
    ++count;
    return std::exp(rate);
  }
};

TEST(ParameterTest, WhatDependsOnThemAloneIsComputedWhenTheyAreSet) {
  TestRig<Amplifier> rig;
  for (const double u : {1.0, 2.0, 3.0}) EXPECT_EQ(rig.Fix(rig->u, u).Tick()[rig->y], u);
  EXPECT_EQ(rig->count, 1);
  const auto before = rig.context().Save();
  rig.Set(rig->rate, 1);
  for (const double u : {1.0, 2.0, 3.0}) EXPECT_EQ(rig.Fix(rig->u, u).Tick()[rig->y], std::exp(1.0) * u);
  EXPECT_EQ(rig->count, 2);
  EXPECT_EQ(rig.context().Clone()->Eval(rig->factor), std::exp(1.0));
  auto restored = rig.diagram().CreateContext();
  restored->Set(rig->rate, 1);
  EXPECT_EQ(restored->Eval(rig->factor), std::exp(1.0));
  restored->Restore(before);
  EXPECT_EQ(restored->Eval(rig->factor), 1);
}

}  // namespace tenon::range_test
