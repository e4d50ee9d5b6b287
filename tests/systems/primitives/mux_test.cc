#include <tenon/systems/primitives/mux.h>
#include <tenon/tests/testing/matchers.h>
#include <tenon/tests/testing/test_rig.h>

#include <gtest/gtest.h>

namespace tenon::mux_test {
namespace {

TEST(MuxTest, MakesAVector) {
  TestRig<Mux<3>> rig;
  auto& u = rig.system().u;
  rig.Fix(u[0], 1).Fix(u[1], 2).Fix(u[2], 3);
  EXPECT_THAT(rig[rig.system().y], IsNear(Vec<3>(1, 2, 3), 0));
}

TEST(MuxTest, NamesTheElements) {
  TestRig<Mux<2>> rig(MuxParams{.units = "m, rad", .elements = "height, pitch"});
  const auto elements = rig.system().y.elements();
  EXPECT_EQ(elements[1].name, "pitch");
  EXPECT_EQ(elements[1].unit, "rad");
}

TEST(DemuxTest, TakesAVectorApart) {
  TestRig<Demux<3>> rig;
  auto& y = rig.system().y;
  rig.Fix(rig.system().u, {1, 2, 3});
  ASSERT_EQ(y.size(), 3u);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(rig[y[i]], i + 1);
}

TEST(DemuxTest, NamesItsPorts) {
  TestRig<Demux<2>> rig(MuxParams{.units = "m, rad", .elements = "height, pitch"});
  EXPECT_EQ(rig.system().y[1].path(), "block.y_1");
  EXPECT_EQ(rig.system().y[1].elements()[0].unit, "rad");
  EXPECT_EQ(rig.system().u.elements()[1].name, "pitch");
}

TEST(DemuxTest, UndoesMux) {
  DiagramBuilder builder;
  auto& mux = builder.Add<Mux<2>>("mux");
  auto& demux = builder.Add<Demux<2>>("demux");
  builder.Connect(mux.y, demux.u);
  const auto diagram = builder.BuildWithOpenInputs();
  const auto context = diagram->CreateContext();
  context->Set(mux.u[0], 5);
  context->Set(mux.u[1], 6);
  EXPECT_EQ(context->Eval(demux.y[0]), 5);
  EXPECT_EQ(context->Eval(demux.y[1]), 6);
}

}  // namespace
}  // namespace tenon::mux_test
