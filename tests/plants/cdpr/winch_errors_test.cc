#include <tenon/plants/cdpr/winch_errors.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::winch_errors_test {
namespace {

const CableVector kCommand = Eigen::Vector4d(10, 50, 200, 0);

CableSignals Moving(const Eigen::Vector4d& rate) {
  CableSignals cables = CableSignals::Zero(4);
  cables.length_rate = rate;
  return cables;
}

TEST(WinchErrorsTest, WithoutErrorsTheyPassTheCommand) {
  TestRig<WinchErrors> rig;
  rig.Fix(rig->command, kCommand).Fix(rig->cables, Moving({1, -1, 0.1, 0})).Tick();
  EXPECT_EQ(rig[rig->tension], kCommand);
}

TEST(WinchErrorsTest, FrictionHelpsACableThatIsPulledOutAndHindersOneThatIsReeledIn) {
  TestRig<WinchErrors> rig(WinchErrorsParams{.friction = 0.1});
  rig.Fix(rig->command, kCommand).Fix(rig->cables, Moving({0.5, -0.5, 0.005, 0})).Tick();
  const Eigen::Vector4d expected(11, 45, 200 * (1 + 0.1 * std::tanh(1)), 0);
  EXPECT_THAT(Eigen::Vector4d(rig[rig->tension]), IsNear(expected, 1e-9));
}

TEST(WinchErrorsTest, EachWinchHasAConstantThatStaysAndARippleThatDoesNot) {
  TestRig<WinchErrors> rig(WinchErrorsParams{.gain_deviation = 0.05, .ripple = 0.02});
  constexpr int kTicks = 4000;
  rig.Fix(rig->command, CableVector::Constant(4, 100)).Fix(rig->cables, Moving(Eigen::Vector4d::Zero()));
  Eigen::Array4d sum = Eigen::Array4d::Zero(), squares = sum;
  for (int n = 0; n < kTicks; ++n) {
    const Eigen::Array4d tension = rig.Tick()[rig->tension].array();
    sum += tension / kTicks;
    squares += tension.square() / kTicks;
  }
  const Eigen::Array4d deviation = (squares - sum.square()).sqrt();
  EXPECT_TRUE((deviation > 1.8).all() && (deviation < 2.2).all()) << deviation.transpose();
  EXPECT_GT((sum - sum.mean()).abs().minCoeff(), 0.2) << "no two alike: " << sum.transpose();
}

TEST(WinchErrorsTest, RefusesSignalsOfAnotherNumberOfCables) {
  const auto refuses = [](int commands, int cables, const auto&... what) {
    TestRig<WinchErrors> rig(WinchErrorsParams{.num_cables = 8});
    rig.Fix(rig->command, CableVector::Zero(commands)).Fix(rig->cables, CableSignals::Zero(cables));
    return Throws<RunError>([&] { rig.Tick(); }, what...);
  };
  EXPECT_TRUE(refuses(4, 8, "'command'", "num_cables"));
  EXPECT_TRUE(refuses(8, 4, "'cables'", "num_cables"));
}

TEST(WinchErrorsTest, RefusesNonsense) {
  EXPECT_TRUE(Refuses<WinchErrors>({.num_cables = 0}, "num_cables"));
}

}  // namespace
}  // namespace tenon::winch_errors_test
