#include <tenon/plants/model/swivel_pulley.h>
#include <tenon/plants/model/vectors.h>
#include <tenon/tests/testing/block_test.h>

#include <numbers>
#include <random>

namespace tenon::vectors_test {

using Eigen::Vector3d;

TEST(RotationBetween, IsTheShortestRotation) {
  const Vector3d from(1, 2, 2), to(0, -3, 1);
  const Eigen::Quaterniond rotation = RotationBetween(from, to);
  EXPECT_THAT(rotation * from.normalized(), IsNear(to.normalized(), 1e-15));
  EXPECT_NEAR(rotation.vec().dot(from), 0, 1e-15);
  EXPECT_NEAR(rotation.norm(), 1, 1e-15);
}

TEST(RotationBetween, TurnsOppositeDirectionsByHalfATurn) {
  const Vector3d from(1, 2, 2);
  EXPECT_THAT(RotationBetween(from, -from) * from, IsNear(-from, 1e-14));
}

constexpr int kPoints = 50;  // on a segment
constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct SegmentDistanceTest : ::testing::Test {
  Vector3d Draw() { return {uniform_(random_), uniform_(random_), uniform_(random_)}; }

 private:
  std::mt19937_64 random_{3};
  std::uniform_real_distribution<double> uniform_{-1, 1};
};

// Against the distances of sampled points of both segments.
TEST_F(SegmentDistanceTest, IsTheLeastOfAllPoints) {
  for (int k = 0; k < 100; ++k) {
    const Vector3d p = Draw(), u = Draw(), q = Draw(), v = k % 10 == 0 ? Vector3d(-1.5 * u) : Draw();
    double least = kInfinity;
    for (int i = 0; i <= kPoints; ++i)
      for (int j = 0; j <= kPoints; ++j)
        least = std::min(least, (p + u * i / kPoints - q - v * j / kPoints).norm());
    Eigen::Vector2d at;
    const double distance = SegmentDistance(p, u, q, v, &at);
    EXPECT_NEAR((p + at[0] * u - q - at[1] * v).norm(), distance, 1e-15);
    EXPECT_LE(distance, least + 1e-12);
    EXPECT_GT(distance, least - 0.08) << k;
  }
}

// A point is as far from a box as from the nearest of a cloud of points that fills it.
TEST_F(SegmentDistanceTest, OfABoxIsTheLeastOfAllPoints) {
  int inside = 0;
  for (int k = 0; k < 200; ++k) {
    const Vector3d half = 0.8 * Draw().cwiseAbs(), p = Draw(), u = k % 10 == 0 ? Vector3d(0, 0, 0.5) : Draw();
    double least = kInfinity;
    for (int i = 0; i <= kPoints; ++i) {
      const Vector3d x = p + u * i / kPoints;
      least = std::min(least, (x.cwiseAbs() - half).cwiseMax(0).norm());
    }
    double at = 0;
    const double distance = SegmentBoxDistance(p, u, half, &at);
    EXPECT_NEAR(((p + at * u).cwiseAbs() - half).cwiseMax(0).norm(), distance, 1e-15);
    EXPECT_LE(distance, least + 1e-8) << k;
    EXPECT_GT(distance, least - 0.02) << k;
    if (least == 0) {
      ++inside;
      EXPECT_EQ(distance, 0);
    }
  }
  EXPECT_GT(inside, 3);
  EXPECT_EQ(SegmentBoxDistance({2, 0, 0}, Vector3d::Zero(), {0.5, 1, 1}), 1.5);
  EXPECT_DOUBLE_EQ(SegmentBoxDistance({-1, 0.9, 0}, {2, 0, 0}, {0.3, 0.2, 0.1}), 0.7);
}

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

}  // namespace tenon::vectors_test
