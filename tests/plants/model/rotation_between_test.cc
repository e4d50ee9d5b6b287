#include <tenon/plants/model/rotation_between.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::rotation_between_test {
namespace {

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

}  // namespace
}  // namespace tenon::rotation_between_test
