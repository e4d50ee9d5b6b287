#include <tenon/plants/legged/internal/per_leg.h>
#include <tenon/systems/framework/block/random_stream.h>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace tenon::internal::per_leg_test {

constexpr int kNumLegs = 4;

TEST(PerLegTest, EachIsComputedLikeADouble) {
  RandomStream random(71);
  double a[kNumLegs], b[kNumLegs];
  for (int i = 0; i < kNumLegs; ++i) a[i] = random.Normal(), b[i] = random.Normal();
  const PerLeg x(a[0], a[1], a[2], a[3]), y = PerLeg::Of([&](int i) { return b[i]; });
  for (int i = 0; i < kNumLegs; ++i) {
    EXPECT_EQ((x + y)[i], a[i] + b[i]);
    EXPECT_EQ((x - y)[i], a[i] - b[i]);
    EXPECT_EQ((x * y)[i], a[i] * b[i]);
    EXPECT_EQ((x / y)[i], a[i] / b[i]);
    EXPECT_EQ((-x)[i], -a[i]);
    EXPECT_EQ((x * 3)[i], a[i] * 3);
  }
  EXPECT_EQ(x.Sum(), a[0] + a[1] + a[2] + a[3]);
}

TEST(PerLegTest, MatricesAreThoseOfTheLegs) {
  RandomStream random(72);
  Matrix3<double> A[kNumLegs];
  Vector3<double> v[kNumLegs];
  Matrix3<PerLeg> M;
  Vector3<PerLeg> x;
  for (int i = 0; i < 9; ++i) M(i) = PerLeg::Of([&](int leg) { return A[leg](i) = random.Normal(); });
  for (int i = 0; i < 3; ++i) x[i] = PerLeg::Of([&](int leg) { return v[leg][i] = random.Normal(); });
  const Matrix3<PerLeg> product = M * M.transpose();
  const Vector3<PerLeg> turned = M * x + x.cross(M.col(1)) - x.dot(x) * Vector3<PerLeg>::UnitZ();
  for (int leg = 0; leg < kNumLegs; ++leg) {
    const Matrix3<double> expected = A[leg] * A[leg].transpose();
    const Vector3<double> expected_turned =
        A[leg] * v[leg] + v[leg].cross(A[leg].col(1)) - v[leg].squaredNorm() * Vector3<double>::UnitZ();
    for (int i = 0; i < 9; ++i) EXPECT_NEAR(product(i)[leg], expected(i), 1e-14);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(turned[i][leg], expected_turned[i], 1e-14);
  }
}

}  // namespace tenon::internal::per_leg_test
