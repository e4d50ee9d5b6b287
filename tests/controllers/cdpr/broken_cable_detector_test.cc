#include <tenon/controllers/cdpr/broken_cable_detector.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::broken_cable_detector_test {

CableVector Of(double a, double b, double c, double d) {
  return Eigen::Vector4d(a, b, c, d);
}

class BrokenCableDetectorTest : public ::testing::Test {
 protected:
  /// The broken cables that are found after `ticks` ticks of 1 ms with these tensions and commands.
  CableVector After(const CableVector& tension, const CableVector& command, int ticks) {
    CableSignals cables = CableSignals::Zero(4);
    cables.tension = tension;
    cables.length = cables.rest_length = CableVector::Constant(4, 5);
    cables.rest_length[0] += slack;
    cables.length_rate[0] = rate;
    rig.Fix(rig->cables, cables).Fix(rig->command, command);
    for (int k = 0; k < ticks; ++k) rig.Tick();
    return rig[rig->broken];
  }
  double slack = 0, rate = 0;  // of the first cable [m], [m/s]
  TestRig<BrokenCableDetector> rig{BrokenCableDetectorParams{.num_cables = 4}};
  const CableVector commands = Of(100, 100, 100, 10);
};

TEST_F(BrokenCableDetectorTest, TakesItsTimeAndNeverForgets) {
  EXPECT_EQ(After(Of(90, 0, 110, 0), commands, 50), Of(0, 0, 0, 0));
  EXPECT_EQ(After(Of(90, 0, 110, 0), commands, 2), Of(0, 1, 0, 0))
      << "the last command is too small to decide";
  EXPECT_EQ(After(Of(90, 100, 110, 10), commands, 100), Of(0, 1, 0, 0));
}

TEST_F(BrokenCableDetectorTest, ACableThatIsSlackForAMomentIsNotBroken) {
  for (int k = 0; k < 5; ++k) {
    EXPECT_EQ(After(Of(90, 0, 110, 10), commands, 45), Of(0, 0, 0, 0));
    EXPECT_EQ(After(Of(90, 21, 110, 10), commands, 2), Of(0, 0, 0, 0)) << "more than a fifth";
  }
}

TEST_F(BrokenCableDetectorTest, ACableShorterThanItsRestLengthIsSlack) {
  slack = 0.01;
  EXPECT_EQ(After(Of(0, 90, 110, 10), commands, 100), Of(0, 0, 0, 0));
  slack = 0;
  EXPECT_EQ(After(Of(0, 90, 110, 10), commands, 100), Of(1, 0, 0, 0));
}

// A winch of 90 N s/m that reels in at 1 m/s leaves 10 N of 100 N; at 0.5 m/s, 55 N.
TEST_F(BrokenCableDetectorTest, ACableThatIsReeledInQuicklyPullsLess) {
  rate = -1;
  EXPECT_EQ(After(Of(0, 90, 110, 10), commands, 100), Of(0, 0, 0, 0));
  rate = -0.5;
  EXPECT_EQ(After(Of(12, 90, 110, 10), commands, 100), Of(0, 0, 0, 0));
  EXPECT_EQ(After(Of(10, 90, 110, 10), commands, 100), Of(1, 0, 0, 0));
}

TEST_F(BrokenCableDetectorTest, IfNoCablePullsTheSensorsHaveFailed) {
  EXPECT_EQ(After(Of(0, 0, 0, 0), commands, 200), Of(0, 0, 0, 0));
}

TEST_F(BrokenCableDetectorTest, RefusesSignalsOfAnotherRobot) {
  const auto refuses = [&](int tensions, int commands) {
    rig.Fix(rig->cables, CableSignals::Zero(tensions)).Fix(rig->command, CableVector::Zero(commands));
    EXPECT_TRUE(Throws<RunError>([&] { rig.Tick(); }, "BrokenCableDetector", "3", "4"));
  };
  refuses(3, 4);
  refuses(4, 3);
}

TEST(BrokenCableDetectorParamsTest, RefusesNonsense) {
  EXPECT_TRUE(Refuses<BrokenCableDetector>({.num_cables = 0}, "num_cables"));
  EXPECT_TRUE(Refuses<BrokenCableDetector>({.share = 1}, "share"));
  EXPECT_TRUE(Refuses<BrokenCableDetector>({.reel_damping = -1}, "reel_damping"));
  EXPECT_TRUE(Refuses<BrokenCableDetector>({.least_tension = 0}, "least_tension"));
  EXPECT_TRUE(Refuses<BrokenCableDetector>({.patience = 0}, "patience"));
}

}  // namespace tenon::broken_cable_detector_test
