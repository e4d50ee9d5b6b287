#include <tenon/plants/legged/foot_contact.h>

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include <tenon/tests/testing/allocation_guard.h>
#include <tenon/tests/testing/matchers.h>

namespace tenon {
namespace {

constexpr double kRadius = 0.03, kGravity = 9.81;

ContactProperties Properties() {
  ContactProperties contact;
  contact.stiffness = 5e4;
  contact.dissipation = 5;
  contact.blend = 2e-4;
  contact.bristle_stiffness = 1000;
  contact.bristle_damping = 1;
  contact.full_friction = 5;
  contact.release_time = 5e-3;
  return contact;
}

Terrain Ground(double friction, double grade = 0) {
  TerrainParams params;
  params.friction = friction;
  params.grade = {grade, 0};
  return Terrain(params);
}

FootContact At(double depth, const Vec<3>& v, const Vec<2>& z = Vec<2>::Zero(),
               const Vec<3>& w = Vec<3>::Zero(), double friction = 0.5) {
  return CalcFootContact(Ground(friction), Properties(), kRadius, {Vec<3>(1, 2, kRadius - depth), v, w}, z);
}

TEST(FootContactTest, NothingInTheAir) {
  const FootContact foot = At(-1e-6, {1, 0, -1}, {1e-4, -2e-4});
  EXPECT_EQ(foot.force_W, Vec<3>::Zero());
  EXPECT_EQ(foot.depth, 0);
  EXPECT_THAT(foot.bristle_rate, IsNear(Vec<2>(-0.02, 0.04), 1e-15));  // forgotten with 5 ms
}

TEST(FootContactTest, NormalForceIsASpringThatDissipates) {
  EXPECT_NEAR(At(1e-3, {0, 0, 0}).force_W[2], 5e4 * (1e-3 - 1e-4), 1e-9);
  EXPECT_NEAR(At(1e-4, {0, 0, 0}).force_W[2], 5e4 * 1e-8 / 4e-4, 1e-9);  // inside the blend
  EXPECT_NEAR(At(1e-3, {0, 0, -0.1}).force_W[2], 45 * 1.5, 1e-9);
  EXPECT_NEAR(At(1e-3, {0, 0, 0.1}).force_W[2], 45 * 0.5, 1e-9);
  EXPECT_EQ(At(1e-3, {0, 0, 0.3}).force_W[2], 0);  // it never pulls
  EXPECT_THAT(At(1e-3, {0, 0, 0}).p_W, IsNear(Vec<3>(1, 2, 0), 1e-15));
}

TEST(FootContactTest, TheBristleIsElasticFirstAndNeverLeavesTheCone) {
  // mu = 0.5: z_max = 0.5 mm, elastic to 0.35 mm.
  const FootContact elastic = At(1e-3, {0.1, 0, 0}, {3e-4, 0});
  EXPECT_THAT(elastic.bristle_rate, IsNear(Vec<2>(0.1, 0), 1e-15));
  EXPECT_NEAR(elastic.force_W[0], -45 * (1000 * 3e-4 + 1 * 0.1), 1e-9);
  const FootContact full = At(1e-3, {0.1, 0, 0}, {5e-4, 0});
  EXPECT_THAT(full.bristle_rate, IsNear(Vec<2>(0, 0), 1e-15));
  EXPECT_NEAR(full.force_W[0], -45 * 0.5, 1e-9);
  EXPECT_THAT(At(1e-3, {-0.1, 0, 0}, {5e-4, 0}).bristle_rate,
              IsNear(Vec<2>(-0.1, 0), 1e-15));  // back at once
  const FootContact fast = At(1e-3, {3, 4, 0});
  EXPECT_THAT(fast.force_W.head<2>(), IsNear(Vec<2>(-0.6, -0.8) * 45 * 0.5, 1e-9));
}

TEST(FootContactTest, ALightFootForgets) {
  const double d = std::sqrt(2.5 * 2 * 2e-4 / 5e4);  // N = k d^2 / (2 b) = 2.5 N: the gate is one half
  const FootContact foot = At(d, {0.1, 0, 0}, {1e-4, 0});
  EXPECT_NEAR(foot.normal_force, 2.5, 1e-9);
  EXPECT_NEAR(foot.bristle_rate[0], 0.5 * 0.1 - 0.5 * 1e-4 / 5e-3, 1e-12);
}

TEST(FootContactTest, RollingIsNotSliding) {
  // The centre moves with w x arm: the material point in contact rests.
  const double depth = 1e-3, speed = 0.2;
  const FootContact foot = At(depth, {speed, 0, 0}, Vec<2>::Zero(), {0, speed / (kRadius - depth), 0});
  EXPECT_THAT(foot.bristle_rate, IsNear(Vec<2>(0, 0), 1e-15));
  EXPECT_THAT(foot.force_W.head<2>(), IsNear(Vec<2>(0, 0), 1e-12));
}

TEST(FootContactTest, WithoutFrictionItSlides) {
  const FootContact foot = At(1e-3, {1, 0, 0}, Vec<2>::Zero(), Vec<3>::Zero(), 0);
  EXPECT_THAT(foot.force_W, IsNear(Vec<3>(0, 0, 45), 1e-9));
}

TEST(FootContactTest, TouchesFloorAndWallAtOnce) {
  TerrainParams params;
  params.boxes = {{{1, 0}, {0.4, 0.4}, 0.2, 0}};
  params.friction = 0;
  const FootContact foot = CalcFootContact(
      Terrain(params), Properties(), kRadius,
      {Vec<3>(0.8 - kRadius + 5e-4, 0, kRadius - 1e-3), Vec<3>::Zero(), Vec<3>::Zero()}, Vec<2>::Zero());
  EXPECT_THAT(foot.force_W, IsNear(Vec<3>(-5e4 * 4e-4, 0, 45), 1e-9));
}

TEST(FootContactTest, DoesNotAllocate) {
  if (!AllocationGuard::Available()) GTEST_SKIP() << "allocations are not counted in this build";
  const Terrain terrain = Ground(0.5);
  const AllocationGuard guard;
  const FootContact foot = CalcFootContact(terrain, Properties(), kRadius,
                                           {Vec<3>(0, 0, 0.029), Vec<3>(1, 0, 0), Vec<3>::Zero()}, {0, 0});
  EXPECT_EQ(guard.count(), 0);
  EXPECT_GT(foot.normal_force, 0);
}

/// A block of 5 kg that does not turn, on a slope; where it is 1 s before the end, and at the end.
struct Block {
  Vec<3> p, v;
  Vec<2> z;
};
std::pair<Block, Block> SlideFor(double duration, double h, double angle, double friction) {
  const Terrain terrain = Ground(friction, std::tan(angle));
  const Vec<3> normal(-std::sin(angle), 0, std::cos(angle));
  const double mass = 5;
  Block x{normal * (kRadius - 9e-4), Vec<3>::Zero(), Vec<2>::Zero()};
  const auto rate = [&](const Block& at) -> Block {
    const FootContact foot =
        CalcFootContact(terrain, Properties(), kRadius, {at.p, at.v, Vec<3>::Zero()}, at.z);
    return {at.v, foot.force_W / mass - Vec<3>(0, 0, kGravity), foot.bristle_rate};
  };
  const auto moved = [](const Block& at, double h, const Block& r) {
    return Block{at.p + h * r.p, at.v + h * r.v, at.z + h * r.z};
  };
  Block early = x;
  const long steps = std::lround(duration / h), last_second = std::lround(1 / h);
  for (long i = 0; i < steps; ++i) {  // Heun
    if (i == steps - last_second) early = x;
    const Block k1 = rate(x), k2 = rate(moved(x, h, k1));
    x = moved(moved(x, h / 2, k1), h / 2, k2);
  }
  return {early, x};
}

TEST(FootContactTest, ABlockSlidesDownASteepSlope) {
  for (const double friction : {0.2, 0.5}) {
    const double angle = 30 * M_PI / 180;
    const auto [early, late] = SlideFor(1.5, 1e-5, angle, friction);
    const Vec<3> down(-std::cos(angle), 0, -std::sin(angle));
    EXPECT_NEAR((late.v - early.v).dot(down), kGravity * (std::sin(angle) - friction * std::cos(angle)),
                1e-5);
  }
}

TEST(FootContactTest, ABlockStaysBelowTheFrictionAngle) {
  const auto [early, late] = SlideFor(9, 1e-4, 30 * M_PI / 180, 0.6);  // tan 30 deg = 0.577
  EXPECT_LT((late.p - early.p).norm(), 1e-8);
  EXPECT_LT(late.v.norm(), 1e-8);
}

}  // namespace
}  // namespace tenon
