#include <tenon/systems/primitives/mux.h>
#include <tenon/tests/testing/test_rig.h>

#include <gtest/gtest.h>

namespace tenon::mux_test {

TEST(MuxTest, NamesTheElements) {
  TestRig<Mux<2>> rig({.units = "m, rad", .elements = "height, pitch"});
  const auto elements = rig->y.elements();
  EXPECT_EQ(elements[1].name, "pitch");
  EXPECT_EQ(elements[1].unit, "rad");
}

TEST(DemuxTest, NamesItsPorts) {
  TestRig<Demux<2>> rig({.units = "m, rad", .elements = "height, pitch"});
  EXPECT_EQ(rig->y[1].path(), "block.y_1");
  EXPECT_EQ(rig->y[1].elements()[0].unit, "rad");
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

}  // namespace tenon::mux_test
