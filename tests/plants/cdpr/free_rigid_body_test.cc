#include <tenon/tests/plants/cdpr/cdpr_plant_test_robot.h>
#include <tenon/tests/testing/block_test.h>
#include <tenon/tests/testing/dense_algebra.h>

#include <Eigen/Geometry>

namespace tenon::free_rigid_body_test {

using test::RandomPlatform, test::RandomVector;

constexpr double kMass = 15;

Eigen::Matrix3d Inertia() {
  Eigen::Matrix3d inertia;
  inertia << 0.213, 0.01, -0.02, 0.01, 0.133, 0.005, -0.02, 0.005, 0.215;
  return inertia;
}

/// Newton for the common CoM and Euler about it, then from there to the body's own CoM.
PlatformAcceleration NewtonEuler(const PlatformState& x, const PlatformWrench& wrench, const Payload& payload,
                                 double gravity) {
  const Eigen::Matrix3d R = x.R_WB();
  const double total = kMass + payload.mass;
  const Vec<3> r = R * payload.p_B;
  const Vec<3> c = payload.mass / total * r;  // from the body's CoM to the common one
  const auto steiner = [](double mass, const Vec<3>& d) -> Eigen::Matrix3d {
    return mass * (d.squaredNorm() * Eigen::Matrix3d::Identity() - d * d.transpose());
  };
  const Eigen::Matrix3d J = R * Inertia() * R.transpose() + steiner(kMass, c) + steiner(payload.mass, r - c);
  const Vec<3> torque = wrench.torque_W - c.cross(wrench.force_W);
  PlatformAcceleration out;
  out.alpha_W = test::Solve(J, torque - x.w_W.cross(J * x.w_W));
  const Vec<3> a_common = wrench.force_W / total - Vec<3>(0, 0, gravity);
  out.a_W = a_common - out.alpha_W.cross(c) - x.w_W.cross(x.w_W.cross(c));
  return out;
}

TEST(FreeRigidBodyTest, ObeysNewtonAndEuler) {
  RandomStream random(1);
  FreeRigidBody body(kMass, Inertia());
  for (int i = 0; i < 30; ++i) {
    PlatformState x = RandomPlatform(random);
    const PlatformWrench wrench{RandomVector(random, 100), RandomVector(random, 10)};
    const Payload payload{i % 3 == 0 ? 0 : random.Uniform(0, 30), RandomVector(random, 0.5)};
    const PlatformAcceleration expected = NewtonEuler(x, wrench, payload, 9.81);
    x.q_WB *= random.Uniform(0.5, 2);  // its length means nothing
    body.Calc(x, wrench, payload, 9.81);
    EXPECT_THAT(body.acceleration().a_W, IsNear(expected.a_W, 1e-10));
    EXPECT_THAT(body.acceleration().alpha_W, IsNear(expected.alpha_W, 1e-10));
  }
}

TEST(FreeRigidBodyTest, SumsKineticEnergy) {
  RandomStream random(3);
  FreeRigidBody body(kMass, Inertia());
  const PlatformState x = RandomPlatform(random);
  const Vec<3> w_B = x.R_WB().transpose() * x.w_W;
  const double bare = kMass / 2 * x.v_W.squaredNorm() + w_B.dot(Inertia() * w_B) / 2;
  body.Calc(x, {}, {}, 9.81);
  EXPECT_NEAR(body.kinetic_energy(), bare, 1e-12);
  const Payload payload{4, {0.1, 0.2, -0.3}};
  body.Calc(x, {}, payload, 9.81);
  const Vec<3> v = x.v_W + x.w_W.cross(x.R_WB() * payload.p_B);
  EXPECT_NEAR(body.kinetic_energy(), bare + 2 * v.squaredNorm(), 1e-12);
}

TEST(FreeRigidBodyTest, DependsOnItsArgumentsAlone) {
  RandomStream random(4);
  FreeRigidBody fresh(kMass, Inertia());
  FreeRigidBody used = fresh;
  for (int i = 0; i < 10; ++i)
    used.Calc(RandomPlatform(random), {RandomVector(random, 9)}, {3, {1, 0, 0}}, 5);
  FreeRigidBody copy;
  copy = used;
  const PlatformState x = RandomPlatform(random);
  const PlatformWrench wrench{RandomVector(random, 9), RandomVector(random, 9)};
  fresh.Calc(x, wrench, {2, {0, 0, 1}}, 9.81);
  used.Calc(x, wrench, {2, {0, 0, 1}}, 9.81);
  copy.Calc(x, wrench, {2, {0, 0, 1}}, 9.81);
  for (const FreeRigidBody* other : {&used, &copy}) {
    EXPECT_EQ(other->acceleration().a_W, fresh.acceleration().a_W);
    EXPECT_EQ(other->acceleration().alpha_W, fresh.acceleration().alpha_W);
    EXPECT_EQ(other->kinetic_energy(), fresh.kinetic_energy());
  }
}

// A default-constructed body can be copied and assigned to, as containers do.
TEST(FreeRigidBodyTest, CopiesBeforeItIsABody) {
  const FreeRigidBody none;
  FreeRigidBody copy(none);
  EXPECT_EQ(copy.kinetic_energy(), 0);
  {
    FreeRigidBody body(kMass, Inertia());
    copy = body;
    body = none;
  }
  const PlatformState x{.v_W = {2, 0, 0}};
  copy.Calc(x, {{30, 0, 0}, {0, 0, 0}}, {}, 9.81);
  EXPECT_THAT(copy.acceleration().a_W, IsNear(Vec<3>(2, 0, -9.81), 1e-14));
  EXPECT_NEAR(copy.kinetic_energy(), 30, 1e-12);
}

TEST(FreeRigidBodyTest, RefusesImpossibleInertias) {
  const Eigen::Matrix3d long_only = Eigen::Vector3d(1, 1, 3).asDiagonal();
  EXPECT_TRUE(Throws<ParameterError>([&] { FreeRigidBody body(1, long_only); }, "1, 1, 3"));
}

}  // namespace tenon::free_rigid_body_test
