#include <tenon/plants/model/cross_matrix.h>
#include <tenon/plants/signals/euler.h>
#include <tenon/tests/testing/matchers.h>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <numbers>

namespace tenon::euler_test {
namespace {

TEST(EulerTest, NearIsTheSameRotationWithinHalfATurn) {
  const Eigen::Vector3d euler(0.3, -0.2, 3.1), near(6.2, -0.1, -9.3);
  const Eigen::Vector3d found = EulerNear(euler, near);
  EXPECT_THAT(RotationFromEuler(found), IsNear(RotationFromEuler(euler), 1e-14));
  EXPECT_LE((found - near).cwiseAbs().maxCoeff(), std::numbers::pi);
  EXPECT_EQ(EulerNear(euler, euler), euler);
}

TEST(CrossMatrixTest, MultipliesAsTheCrossProduct) {
  const Eigen::Vector3d a(0.3, -1.2, 2.5), b(-0.7, 0.4, 1.1);
  EXPECT_THAT(CrossMatrix(a) * b, IsNear(a.cross(b), 1e-15));
}

}  // namespace
}  // namespace tenon::euler_test
