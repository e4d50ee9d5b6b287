#include <tenon/plants/model/vectors.h>
#include <tenon/tests/testing/block_test.h>

#include <algorithm>
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

class SegmentDistanceTest : public ::testing::Test {
 protected:
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
    const double distance = SegmentDistance(p, u, q, v);
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
    const double distance = SegmentBoxDistance(p, u, half);
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

}  // namespace tenon::vectors_test
