#include <tenon/systems/primitives/concatenate.h>
#include <tenon/systems/primitives/zero_order_hold.h>
#include <tenon/tests/testing/block_test.h>

#include <vector>

namespace tenon::concatenate_test {

struct Trunk {
  double height = 0;
  Vec<3> p_W = Vec<3>::Zero();
  bool stands = false;
  static FieldList Fields() {
    return {{"height", &Trunk::height, "m"}, {"p_W", &Trunk::p_W, "m"}, {"stands", &Trunk::stands}};
  }
};
using All = Concatenate<double, Vec<2>, Trunk, int>;
using Parts = Split<double, Vec<2>, Trunk, int>;
const std::vector<Spec> kPorts = {{"mass", "kg"}, {"force", "N", "x, z"}, "trunk", "gait"};

TEST(ConcatenateTest, NamesTheElements) {
  const All block({.ports = kPorts});
  std::string names, units;
  for (const Element& element : block.y.elements()) {
    names += element.name + " ";
    units += element.unit + " ";
  }
  EXPECT_EQ(names,
            "mass force.x force.z trunk.height trunk.p_W.x trunk.p_W.y trunk.p_W.z trunk.stands gait ");
  EXPECT_EQ(units, "kg N N m m m m   ");
  Concatenate<double, double> plain;
  EXPECT_EQ(plain.u<1>().name(), "u_1");
}

TEST(SplitTest, UndoesConcatenate) {
  DiagramBuilder builder;
  auto& all = builder.Add<All>("all", {.ports = kPorts});
  auto& parts = builder.Add<Parts>("parts", {.ports = kPorts});
  builder.Connect(all.y, parts.u);
  const auto context = builder.BuildWithOpenInputs()->CreateContext();
  context->Set(all.u<0>(), 1);
  context->Set(all.u<1>(), {2, 3});
  context->Set(all.u<2>(), {4, {5, 6, 7}, true});
  context->Set(all.u<3>(), 9);
  EXPECT_EQ(context->Eval(all.y), (Vec<9>(1, 2, 3, 4, 5, 6, 7, 1, 9)));
  EXPECT_EQ(context->Eval(parts.y<0>()), 1);
  EXPECT_EQ(context->Eval(parts.y<1>()), Vec<2>(2, 3));
  EXPECT_EQ(context->Eval(parts.y<2>()).p_W, Vec<3>(5, 6, 7));
  EXPECT_TRUE(context->Eval(parts.y<2>()).stands);
  EXPECT_EQ(context->Eval(parts.y<3>()), 9);
  EXPECT_EQ(parts.y<1>().path(), "parts.force");
}

TEST(SplitTest, RefusesAnotherSize) {
  TestRig<Split<double, Vec<2>>> rig;
  rig.Fix(rig->u, Eigen::VectorXd::Zero(4));
  EXPECT_TRUE(Throws<RunError>([&] { rig[rig->y<1>()]; }, "'block.y_1'"));
}

TEST(ConcatenateTest, DoesNotAllocate) {
  using Three = Vec<3>;
  DiagramBuilder builder;
  auto& wave = builder.AddFunction("wave", Uses(builder.time), [](double t) { return Three(t, 2, 3); });
  auto& all = builder.Add<Concatenate<Three, Three>>("all");
  auto& parts = builder.Add<Split<Vec<2>, Vec<4>>>("parts");
  auto& hold = builder.Add<ZeroOrderHold<Vec<4>>>("hold");
  builder.Connect(wave, all.u<0>());
  builder.Connect(wave, all.u<1>());
  builder.Connect(all.y, parts.u);
  builder.Connect(parts.y<1>(), hold.u);
  Simulator simulator(builder.Build());
  simulator.RunTo(0.1);
  EXPECT_THAT(simulator.context().Eval(hold.y), IsNear(Vec<4>(3, 0.1, 2, 3), 1e-15));
  EXPECT_EQ(AllocationsOf([&] { simulator.RunTo(0.2); }), 0);
}

TEST(ConcatenateTest, RefusesWrongNumbersOfNamesAndSizesThatAreNotFixed) {
  EXPECT_TRUE(
      Throws<ParameterError>([] { Concatenate<double, double> block({.ports = {"height"}}); }, "ports"));
  EXPECT_TRUE(Throws<ParameterError>([] { Split<double, Eigen::VectorXd> block; }, "'y_1'"));
}

}  // namespace tenon::concatenate_test
