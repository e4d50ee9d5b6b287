#include <tenon/plants/model/vectors.h>
#include <tenon/plants/signals/euler.h>
#include <tenon/plants/signals/ground_plane.h>
#include <tenon/tests/testing/block_test.h>

#include <numbers>

namespace tenon::ground_plane_test {

const GroundPlane kRamp{.p_W = {1, 2, 0.5}, .slope = {0.3, -0.2}};

TEST(GroundPlaneTest, IsLevelIfNothingElseIsSaid) {
  EXPECT_EQ(GroundPlane().HeightAt({3, 4}), 0);
  EXPECT_EQ(GroundPlane().Normal(), Vec<3>(0, 0, 1));
  EXPECT_EQ(EulerOnSlope({0, 0}, 0.7), Eigen::Vector3d(0, 0, 0.7));
}

TEST(GroundPlaneTest, PointsOfItLieAcrossItsNormal) {
  const Eigen::Vector2d place(-2, 1);
  const Vec<3> point(place[0], place[1], kRamp.HeightAt(place));
  EXPECT_NEAR(kRamp.HeightAt(place), 0.5 + 0.3 * -3 + -0.2 * -1, 1e-15);
  EXPECT_NEAR(kRamp.Normal().dot(point - kRamp.p_W), 0, 1e-15);
  EXPECT_NEAR(kRamp.Normal().norm(), 1, 1e-15);
  EXPECT_THAT(kRamp.ContactArm(0.02), IsNear(-0.02 * kRamp.Normal(), 1e-17));
}

TEST(GroundPlaneTest, TrunksOnItAreParallelAndHeadAsTheyShould) {
  for (const double yaw : {-2.0, 0.0, 0.9, 3.0}) {
    const Eigen::Matrix3d R = RotationFromEuler(EulerOnSlope(kRamp.slope, yaw));
    EXPECT_THAT(R.col(2), IsNear(kRamp.Normal(), 1e-15));
    EXPECT_NEAR(std::remainder(std::atan2(R(1, 0), R(0, 0)) - yaw, 2 * M_PI), 0, 1e-15);
    EXPECT_THAT(FootprintOnSlope(kRamp.slope, yaw) * Eigen::Vector2d(1, 2),
                IsNear((R * Eigen::Vector3d(1, 2, 0)).head<2>(), 1e-15));
  }
}

TEST(GroundPlaneTest, RatesAreThoseOfDifferences) {
  const Eigen::Vector2d slope_rate(0.4, 0.7);
  const double yaw = 0.9, yaw_rate = -1.3, h = 1e-6;
  const auto at = [&](double t) { return EulerOnSlope(kRamp.slope + t * slope_rate, yaw + t * yaw_rate); };
  EXPECT_THAT(EulerRateOnSlope(kRamp.slope, slope_rate, yaw, yaw_rate),
              IsNear((at(h) - at(-h)) / (2 * h), 1e-9));
}

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

}  // namespace tenon::ground_plane_test
