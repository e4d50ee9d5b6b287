#include <tenon/plants/cdpr/payload_schedule.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::payload_schedule_test {
namespace {

TEST(PayloadScheduleTest, HangsThePayloadFromAttachToRelease) {
  PayloadScheduleParams params;
  params.payload.mass = 5;
  params.attach_s = 1;
  params.release_s = 2;
  TestRig<PayloadSchedule> rig(params);
  const auto mass_at = [&](double time) { return rig.RunTo(time)[rig->payload].mass; };
  EXPECT_EQ(mass_at(0.999), 0);
  EXPECT_EQ(mass_at(1), 5);
  EXPECT_EQ(mass_at(1.999), 5);
  EXPECT_EQ(mass_at(2), 0);
}

TEST(PayloadScheduleTest, RefusesNonsense) {
  PayloadScheduleParams params;
  params.attach_s = 3;
  EXPECT_TRUE(Refuses<PayloadSchedule>(params, "release_s", "attach_s"));
}

TEST(PayloadScheduleTest, LoadAndTimesAreSetInARun) {
  TestRig<PayloadSchedule> rig;
  EXPECT_EQ(rig.RunTo(1)[rig->payload].mass, 0);
  rig.context().Set(rig->load, Payload{.mass = 3}, rig->attach, 1.5, rig->release, 2.0);
  EXPECT_EQ(rig.RunTo(1.49)[rig->payload].mass, 0);
  EXPECT_EQ(rig.RunTo(1.5)[rig->payload].mass, 3);
  rig.Set(rig->release, 1.8);
  EXPECT_EQ(rig.RunTo(1.8)[rig->payload].mass, 0);
  EXPECT_TRUE(Throws<ParameterError>([&] { rig.Set(rig->release, 1); }, "release_s = 1", "1.5"));
}

}  // namespace
}  // namespace tenon::payload_schedule_test
