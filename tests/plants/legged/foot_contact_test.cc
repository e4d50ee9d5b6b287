#include <tenon/plants/legged/foot_contact.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/testing/block_test.h>

#include <Eigen/Geometry>

namespace tenon::foot_contact_test {

constexpr double kRadius = 0.03, kGravity = 9.81;

ContactProperties Properties() {
  return {.stiffness = 5e4,
          .dissipation = 5,
          .blend = 2e-4,
          .bristle_stiffness = 1000,
          .bristle_damping = 1,
          .bristle_friction = 0.2,
          .full_friction = 5,
          .release_time = 5e-3};
}

Terrain Ground(double friction, double grade = 0) {
  return Terrain({.grade = {grade, 0}, .friction = friction});
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
  EXPECT_THAT(foot.slip_W, IsNear(Vec<3>(1, 0, 0), 1e-15));
}

// Below mu_0 friction is proportional to mu, and the motion of the bristle does not depend on mu.
TEST(FootContactTest, FrictionGoesToZeroWithItsCoefficient) {
  RandomStream random(7);
  for (int i = 0; i < 20; ++i) {
    const Vec<3> v = test::RandomVector<3>(random, 0.2), w = test::RandomVector<3>(random, 2);
    const Vec<2> z = test::RandomVector<2>(random, 2e-4);
    const FootContact full = At(1e-3, v, z, w, 0.2);
    for (const double mu : {0.1, 1e-3, 1e-6, 1e-12, 1e-300, 5e-324}) {
      const FootContact foot = At(1e-3, v, z, w, mu);
      EXPECT_THAT(foot.bristle_rate, IsNear(full.bristle_rate, 1e-14)) << mu;
      EXPECT_THAT(foot.force_W.head<2>(), IsNear(mu / 0.2 * full.force_W.head<2>(), 1e-14 * mu * 45 + 1e-320))
          << mu;
      EXPECT_EQ(foot.force_W[2], full.force_W[2]) << mu;
    }
    const FootContact below = At(1e-3, v, z, w, 0.2 - 1e-9), above = At(1e-3, v, z, w, 0.2 + 1e-9);
    EXPECT_THAT(below.force_W, IsNear(above.force_W, 1e-5));
    EXPECT_THAT(below.bristle_rate, IsNear(above.bristle_rate, 1e-6));
  }
}

// |z'| <= |v|, and the Jacobian of z' by z is at most 5 |v| / z_max with z_max >= 0.2 mm.
TEST(FootContactTest, TheBristleIsNoStifferThanThatOfTheLeastCoefficient) {
  const Vec<3> v(0.6, 0.8, 0);  // 1 m/s
  for (const double mu : {5e-324, 1e-300, 1e-12, 1e-6, 1e-3, 0.1, 0.6, 10.0}) {
    const double z_max = std::max(mu, 0.2) / 1000;
    double rate = 0, jacobian = 0;
    for (int i = 0; i <= 40; ++i) {
      for (int k = 0; k < 24; ++k) {
        const double r = z_max * i / 40, angle = k * M_PI / 12, step = 1e-6 * z_max;
        const Vec<2> z(r * std::cos(angle), r * std::sin(angle));
        rate = std::max(rate, At(1e-3, v, z, Vec<3>::Zero(), mu).bristle_rate.norm());
        Eigen::Matrix2d J;
        for (int j = 0; j < 2; ++j)
          J.col(j) = (At(1e-3, v, z + step * Vec<2>::Unit(j), Vec<3>::Zero(), mu).bristle_rate -
                      At(1e-3, v, z - step * Vec<2>::Unit(j), Vec<3>::Zero(), mu).bristle_rate) /
                     (2 * step);
        jacobian = std::max(jacobian, J.jacobiSvd().singularValues()[0]);
      }
    }
    EXPECT_LE(rate, 1 + 1e-9) << mu;
    EXPECT_LE(jacobian, 5 / z_max) << mu;
    EXPECT_GT(jacobian, 4 / z_max) << mu;  // the bound is near
  }
}

// The friction of a foot that slides in several contacts is the sum over the contacts.
TEST(FootContactTest, SlidesAlongFloorAndWallOfDifferentFriction) {
  for (const auto& [floor, wall] : {std::pair{10.0, 0.0}, {0.0, 10.0}, {1e-3, 0.6}, {5e-324, 5e-324}}) {
    const TerrainParams params{.friction = floor, .boxes = {{{1, 0}, {0.4, 0.4}, 0.2, wall}}};
    const FootContact foot = CalcFootContact(
        Terrain(params), Properties(), kRadius,
        {Vec<3>(0.8 - kRadius + 5e-4, 0, kRadius - 1e-3), Vec<3>(0, 50, 0), Vec<3>::Zero()}, Vec<2>::Zero());
    EXPECT_NEAR(foot.force_W[1], -(45 * floor + 20 * wall), 1e-9);
    EXPECT_THAT(Vec<2>(foot.force_W[0], foot.force_W[2]), IsNear(Vec<2>(-20, 45), 1e-9));
  }
}

/// A block of 5 kg that does not turn.
struct Block {
  Vec<3> p, v;
  Vec<2> z;
};
constexpr double kMass = 5;

/// The block after `steps` steps of Heun's method.
Block Slide(const Terrain& terrain, Block x, long steps, double h) {
  const auto rate = [&](const Block& at) -> Block {
    const FootContact foot =
        CalcFootContact(terrain, Properties(), kRadius, {at.p, at.v, Vec<3>::Zero()}, at.z);
    return {at.v, foot.force_W / kMass - Vec<3>(0, 0, kGravity), foot.bristle_rate};
  };
  const auto moved = [](const Block& at, double h, const Block& r) {
    return Block{at.p + h * r.p, at.v + h * r.v, at.z + h * r.z};
  };
  for (long i = 0; i < steps; ++i) {
    const Block k1 = rate(x), k2 = rate(moved(x, h, k1));
    x = moved(moved(x, h / 2, k1), h / 2, k2);
  }
  return x;
}

/// The block on a slope, 1 s before the end and at the end.
std::pair<Block, Block> SlideFor(double duration, double h, double angle, double friction) {
  const Terrain terrain = Ground(friction, std::tan(angle));
  const Vec<3> normal(-std::sin(angle), 0, std::cos(angle));
  const Block start{normal * (kRadius - 9e-4), Vec<3>::Zero(), Vec<2>::Zero()};
  const long steps = std::lround(duration / h), last_second = std::lround(1 / h);
  const Block early = Slide(terrain, start, steps - last_second, h);
  return {early, Slide(terrain, early, last_second, h)};
}

/// A block on level ground whose contact carries its weight: k (d - b / 2) = m g.
Block Sliding(double x, double height, double speed) {
  const double depth = kMass * kGravity / 5e4 + 1e-4;
  return {Vec<3>(x, 0, height + kRadius - depth), Vec<3>(speed, 0, 0), Vec<2>::Zero()};
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

// A sliding block decelerates by mu g for every mu.
TEST(FootContactTest, ABlockIsBrakedByMuG) {
  for (const double mu : {0.0, 1e-12, 1e-9, 1e-6, 1e-4, 1e-3, 1e-2, 0.05, 0.1, 0.2, 0.6, 1.0, 3.0, 10.0}) {
    const double duration = 0.05, h = 1e-5, speed = 1 + 2 * mu * kGravity * duration;
    const Block end = Slide(Ground(mu), Sliding(0, 0, speed), std::lround(duration / h), h);
    EXPECT_NEAR(speed - end.v[0], mu * kGravity * duration, 1e-4 * mu + 1e-12)
        << mu;  // rounding of v adds up
  }
}

// From a box with mu = 10 the block slides onto one with another mu. 4 cm beyond the seam the bristle, at
// first 10 mm long, has adapted: the block, which bounces a little, loses mu times the impulse of the normal
// force.
TEST(FootContactTest, ABlockSlidesAcrossASeamOfFriction) {
  for (const double mu : {0.0, 1e-9, 1e-3, 0.1, 1.0}) {
    const Terrain terrain({.boxes = {{{-0.5, 0}, {1, 1}, 0.1, 10}, {{0.5, 0}, {1, 1}, 0.1, mu}}});
    const double h = 1e-5;
    Block x = Sliding(-0.1, 0.1, 6);
    while (x.p[0] < 0.04 && x.v[0] > 0) x = Slide(terrain, x, 1, h);
    ASSERT_GE(x.p[0], 0.04) << mu;
    const Block end = Slide(terrain, x, 1000, h);
    EXPECT_NEAR(x.v[0] - end.v[0], mu * (kGravity * 0.01 + end.v[2] - x.v[2]), 1e-3 * mu + 1e-12) << mu;
  }
}

}  // namespace tenon::foot_contact_test
