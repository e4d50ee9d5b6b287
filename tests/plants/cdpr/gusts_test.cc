#include <tenon/plants/cdpr/gusts.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::gusts_test {
namespace {

TEST(GustsTest, RiseToTheirPeaksAndFallAndAddUp) {
  TestRig<Gusts> rig(GustsParams{{{{20, 0, 0}, 1, 2}, {{0, 10, 0}, 2, 4}}});
  const auto at = [&](double time) { return rig.RunTo(time)[rig->wrench]; };
  EXPECT_THAT(at(1).force_W, IsNear(Vec<3>(0, 0, 0), 1e-12));
  EXPECT_THAT(at(1.5).force_W, IsNear(Vec<3>(10, 0, 0), 1e-12));
  EXPECT_THAT(at(2).force_W, IsNear(Vec<3>(20, 0, 0), 1e-12));
  EXPECT_THAT(at(2.5).force_W, IsNear(Vec<3>(10, 5 - 5 * std::sqrt(0.5), 0), 1e-12));
  EXPECT_THAT(at(4).force_W, IsNear(Vec<3>(0, 10, 0), 1e-12));
  EXPECT_THAT(at(6.5).force_W, IsNear(Vec<3>(0, 0, 0), 1e-12));
  EXPECT_EQ(at(7).torque_W, Vec<3>(0, 0, 0));
}

}  // namespace
}  // namespace tenon::gusts_test
