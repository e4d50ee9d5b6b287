// Blocks that join, split and select signals.

#include <tenon/systems/primitives/concatenate.h>
#include <tenon/systems/primitives/switch.h>
#include <tenon/systems/primitives/zero_order_hold.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::routing_test {

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

TEST(ConcatenateTest, RefusesWrongNumbersOfNamesAndSizesThatAreNotFixed) {
  EXPECT_TRUE(
      Throws<ParameterError>([] { Concatenate<double, double> block({.ports = {"height"}}); }, "ports"));
  EXPECT_TRUE(Throws<ParameterError>([] { Split<double, Eigen::VectorXd> block; }, "'y_1'"));
}

TEST(MuxTest, NamesTheElements) {
  TestRig<Mux<2>> rig({.units = "m, rad", .elements = "height, pitch"});
  const auto elements = rig->y.elements();
  EXPECT_EQ(elements[1].name, "pitch");
}

TEST(DemuxTest, NamesItsPorts) {
  TestRig<Demux<2>> rig({.units = "m, rad", .elements = "height, pitch"});
  EXPECT_EQ(rig->y[1].path(), "block.y_1");
  EXPECT_EQ(rig->u.elements()[1].name, "pitch");
}

TEST(DemuxTest, UndoesMux) {
  DiagramBuilder builder;
  auto& mux = builder.Add<Mux<3>>("mux");
  auto& demux = builder.Add<Demux<3>>("demux");
  builder.Connect(mux.y, demux.u);
  const auto context = builder.BuildWithOpenInputs()->CreateContext();
  for (int i = 0; i < 3; ++i) context->Set(mux.u[i], i + 1.0);
  EXPECT_EQ(context->Eval(mux.y), Vec<3>(1, 2, 3));
  ASSERT_EQ(demux.y.size(), 3u);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(context->Eval(demux.y[i]), i + 1);
}

enum class Gait { kStand, kTrot, kPace };

TEST(MultiportSwitchTest, SelectsByNumber) {
  TestRig<MultiportSwitch<Vec<2>>> rig({.count = 3, .unit = "m", .elements = "x, z"});
  for (int i = 0; i < 3; ++i) rig.Fix(rig->u[static_cast<std::size_t>(i)], {i, -i});
  for (int i = 0; i < 3; ++i) EXPECT_THAT(rig.Fix(rig->select, i)[rig->y], IsNear(Vec<2>(i, -i), 0));
  EXPECT_EQ(rig->u[2].path(), "block.u_2");
  EXPECT_EQ(rig->u[2].elements()[1].name, "z");
}

TEST(MultiportSwitchTest, SelectsByEnumeration) {
  TestRig<MultiportSwitch<std::string, Gait>> rig({.count = 3});
  rig.Fix(rig->u[0], "stand").Fix(rig->u[1], "trot").Fix(rig->u[2], "pace");
  EXPECT_EQ(rig.Fix(rig->select, Gait::kPace)[rig->y], "pace");
}

TEST(MultiportSwitchTest, RefusesNumbersOfNoSignal) {
  TestRig<MultiportSwitch<>> rig({.count = 2});
  rig.Fix(rig->u[0], 1).Fix(rig->u[1], 2);
  for (const int bad : {-1, 2}) {
    rig.Fix(rig->select, bad);
    EXPECT_TRUE(Throws<RunError>([&] { rig[rig->y]; }, "'block.y'", "select is " + std::to_string(bad)));
  }
}

TEST(MultiportSwitchTest, RefusesToChooseFromNothing) {
  EXPECT_TRUE(Refuses<MultiportSwitch<>>({.count = 0}, "count"));
}

TEST(SwitchTest, Selects) {
  TestRig<Switch<Vec<2>>> rig;
  rig.Fix(rig->on, {1, 2}).Fix(rig->off, {3, 4});
  EXPECT_THAT(rig.Fix(rig->select, true)[rig->y], IsNear(Vec<2>(1, 2), 0));
  EXPECT_THAT(rig.Fix(rig->select, false)[rig->y], IsNear(Vec<2>(3, 4), 0));
}

TEST(ThresholdSwitchTest, ComparesWithItsThreshold) {
  TestRig<ThresholdSwitch<>> rig({.threshold = 0.5});
  rig.Fix(rig->on, 1).Fix(rig->off, -1);
  EXPECT_EQ(rig.Fix(rig->control, 0.4)[rig->y], -1);
  EXPECT_EQ(rig.Fix(rig->control, 0.5)[rig->y], 1);
  EXPECT_EQ(rig.Fix(rig->control, 0.6)[rig->y], 1);
}

}  // namespace tenon::routing_test
