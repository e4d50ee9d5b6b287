#include <tenon/controllers/cdpr/cable_pd.h>
#include <tenon/tests/plants/model/cdpr_test_robots.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::cable_pd_test {

class CablePdTest : public ::testing::Test {
 protected:
  CablePdTest() {
    reference.length = CableVector::Constant(4, 6);
    reference.length_rate = CableVector::Constant(4, 0.1);
    reference.tension = CableVector::Constant(4, 110);
    cables.length = reference.length;
    cables.length_rate = reference.length_rate;
  }
  CableVector Command() {
    rig.Fix(rig->cables, cables).Fix(rig->reference, reference).Tick();
    return rig[rig->command];
  }

  TestRig<CablePd> rig{CablePdParams{test::FourCableRobot(), 1000, 50}};
  CdprReference reference;
  CableSignals cables = CableSignals::Zero(4);
};

TEST_F(CablePdTest, GivesTheTensionOfTheEquilibriumOnTheReference) {
  EXPECT_THAT(Command(), IsNear(CableVector::Constant(4, 110), 1e-12));
}

TEST_F(CablePdTest, PullsACableThatIsTooLongOrGrowsTooFast) {
  cables.length[1] += 0.02;      // + 1000 N/m * 0.02 m
  cables.length_rate[2] += 0.3;  // + 50 N s/m * 0.3 m/s
  CableVector expected = CableVector::Constant(4, 110);
  expected[1] = 130;
  expected[2] = 125;
  EXPECT_THAT(Command(), IsNear(expected, 1e-9));
}

TEST_F(CablePdTest, StaysInsideTheBounds) {
  cables.length[0] -= 5;
  cables.length[3] += 5;
  const CableVector command = Command();
  EXPECT_EQ(command[0], 0);
  EXPECT_EQ(command[3], 800);
}

TEST(CablePdLimitsTest, EveryCableHasLimitsOfItsOwn) {
  CablePdParams params{test::FourCableRobot(), 1000, 50};
  params.robot.cables[1].tension_max = 200;
  params.robot.cables[2].tension_min = 30;
  TestRig<CablePd> rig(params);
  const CableVector zero = CableVector::Zero(4), tension{{300, 300, 10, 10}};
  rig.Fix(rig->reference, {.length = zero, .length_rate = zero, .tension = tension});
  rig.Fix(rig->cables, CableSignals::Zero(4)).Tick();
  EXPECT_EQ(rig[rig->command], (CableVector{{300, 200, 30, 10}}));
}

TEST(CablePdGainsTest, EveryCableHasGainsOfItsOwn) {
  CablePdParams params{test::FourCableRobot(), {1000, 2000, 3000, 4000}, {50, 60, 70, 80}};
  TestRig<CablePd> rig(params);
  CdprReference reference;
  reference.length = reference.length_rate = CableVector::Zero(4);
  reference.tension = CableVector::Constant(4, 100);
  CableSignals cables = CableSignals::Zero(4);
  cables.length.setConstant(0.02);
  cables.length_rate.setConstant(0.1);
  rig.Fix(rig->cables, cables).Fix(rig->reference, reference).Tick();
  EXPECT_THAT(rig[rig->command], IsNear(CableVector{{125, 146, 167, 188}}, 1e-9));
  params.damping_N_s_per_m = {50, 60, 70};
  EXPECT_TRUE(Refuses<CablePd>(params, "damping"));
  EXPECT_TRUE(Throws<ParameterError>([&] { rig.Set(rig->stiffness, {1, 2}); }, "stiffness"));
}

}  // namespace tenon::cable_pd_test
