#include <tenon/plants/model/swivel_pulley.h>
#include <tenon/tests/testing/block_test.h>

#include <numbers>

namespace tenon::swivel_pulley_test {

constexpr double kRadius = 0.04;
constexpr double kPi = std::numbers::pi;

double Length(double x, double z) {
  const PulleyContact contact = LeaveStraight(kRadius, x, z);
  return kRadius * contact.wrap + contact.free_length;
}

TEST(SwivelPulleyTest, LeavesItUpLevelAndDown) {
  const PulleyContact up = LeaveStraight(kRadius, 0, 4);
  EXPECT_NEAR(up.wrap, 0, 1e-15);
  EXPECT_NEAR(up.free_length, 4, 1e-15);
  const PulleyContact level = LeaveStraight(kRadius, 5 + kRadius, kRadius);  // from the top of the pulley
  EXPECT_NEAR(level.wrap, kPi / 2, 1e-15);
  EXPECT_NEAR(level.free_length, 5, 1e-14);
  const PulleyContact down = LeaveStraight(kRadius, 2 * kRadius, -3);  // from its far side
  EXPECT_NEAR(down.wrap, kPi, 1e-15);
  EXPECT_NEAR(down.free_length, 3, 1e-15);
  const PulleyContact below = LeaveStraight(kRadius, 0.01, -3);  // nearer to the post than that
  EXPECT_GT(below.wrap, kPi);
  EXPECT_LT(below.wrap, 1.01 * kPi);
}

TEST(SwivelPulleyTest, TheTangentAtTheExitEndsAtTheAttachment) {
  RandomStream random(1);
  for (int i = 0; i < 100; ++i) {
    const double x = random.Uniform(0.001, 6), z = random.Uniform(-4, 4);
    if (std::hypot(x - kRadius, z) <= kRadius) continue;
    const PulleyContact contact = LeaveStraight(kRadius, x, z);
    const Vec<2> exit = ExitPoint(kRadius, contact.wrap);
    const Vec<2> along(std::sin(contact.wrap), std::cos(contact.wrap));
    EXPECT_THAT(Vec<2>(exit + contact.free_length * along), IsNear(Vec<2>(x, z), 1e-13));
    EXPECT_NEAR((exit - Vec<2>(kRadius, 0)).norm(), kRadius, 1e-15);
    EXPECT_NEAR((exit - Vec<2>(kRadius, 0)).dot(along), 0, 1e-15);
    EXPECT_GE(contact.wrap, 0);
    EXPECT_NEAR(WrapOf(along[0], along[1]), contact.wrap, 1e-13);
  }
}

TEST(SwivelPulleyTest, TheDirectionIsTheGradientOfTheLength) {
  RandomStream random(2);
  const double h = 1e-6;
  for (int i = 0; i < 50; ++i) {
    const double x = random.Uniform(0.2, 6), z = random.Uniform(-4, 4);
    const double wrap = LeaveStraight(kRadius, x, z).wrap;
    const Vec<2> gradient((Length(x + h, z) - Length(x - h, z)) / (2 * h),
                          (Length(x, z + h) - Length(x, z - h)) / (2 * h));
    EXPECT_THAT(gradient, IsNear(Vec<2>(std::sin(wrap), std::cos(wrap)), 1e-9));
  }
}

}  // namespace tenon::swivel_pulley_test
