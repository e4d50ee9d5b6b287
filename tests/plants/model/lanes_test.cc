#include <gtest/gtest.h>
#include <tenon/plants/model/internal/lanes.h>
#include <tenon/systems/framework/random_stream.h>

#include <Eigen/Geometry>

namespace tenon::internal {
namespace {

constexpr int kLanes = 4;

TEST(LanesTest, EachIsComputedLikeADouble) {
  RandomStream random(71);
  double a[kLanes], b[kLanes];
  for (int i = 0; i < kLanes; ++i) a[i] = random.Normal(), b[i] = random.Normal();
  const Lanes x(a[0], a[1], a[2], a[3]), y = Lanes::Of([&](int i) { return b[i]; });
  for (int i = 0; i < kLanes; ++i) {
    EXPECT_EQ((x + y)[i], a[i] + b[i]);
    EXPECT_EQ((x - y)[i], a[i] - b[i]);
    EXPECT_EQ((x * y)[i], a[i] * b[i]);
    EXPECT_EQ((x / y)[i], a[i] / b[i]);
    EXPECT_EQ((-x)[i], -a[i]);
    EXPECT_EQ((x * 3)[i], a[i] * 3);
  }
  EXPECT_EQ(x.Sum(), a[0] + a[1] + a[2] + a[3]);
}

TEST(LanesTest, MatricesAreThoseOfTheLegs) {
  RandomStream random(72);
  Matrix3<double> A[kLanes];
  Vector3<double> v[kLanes];
  Matrix3<Lanes> M;
  Vector3<Lanes> x;
  for (int i = 0; i < 9; ++i) M(i) = Lanes::Of([&](int leg) { return A[leg](i) = random.Normal(); });
  for (int i = 0; i < 3; ++i) x[i] = Lanes::Of([&](int leg) { return v[leg][i] = random.Normal(); });
  const Matrix3<Lanes> product = M * M.transpose();
  const Vector3<Lanes> turned = M * x + x.cross(M.col(1)) - x.dot(x) * Vector3<Lanes>::UnitZ();
  for (int leg = 0; leg < kLanes; ++leg) {
    const Matrix3<double> expected = A[leg] * A[leg].transpose();
    const Vector3<double> expected_turned =
        A[leg] * v[leg] + v[leg].cross(A[leg].col(1)) - v[leg].squaredNorm() * Vector3<double>::UnitZ();
    for (int i = 0; i < 9; ++i) EXPECT_NEAR(product(i)[leg], expected(i), 1e-14);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(turned[i][leg], expected_turned[i], 1e-14);
  }
}

}  // namespace
}  // namespace tenon::internal
