#include <tenon/plants/surroundings/leash.h>
#include <tenon/plants/surroundings/person.h>
#include <tenon/systems/primitives/constant.h>
#include <tenon/tests/testing/block_test.h>

#include <Eigen/Geometry>

namespace tenon::person_test {

constexpr double kMass = 70, kDamping = 400, kStiffness = 1300;

PersonParams Params(std::vector<PersonPhase> phases = {}) {
  return {.mass = kMass,
          .damping = kDamping,
          .stiffness = kStiffness,
          .hand_height = 0.75,
          .start = {-1, 2},
          .phases = std::move(phases)};
}

LeashState Pull(double tension, const Vec<3>& direction_W) {
  return {.length = 1, .tension = tension, .direction_W = direction_W};
}

/// m e'' + c e' + k e = 0, underdamped, from e0 and rate0: e after t.
double Oscillator(double c, double k, double e0, double rate0, double t) {
  const double decay = c / (2 * kMass), w = std::sqrt(k / kMass - decay * decay);
  return std::exp(-decay * t) * (e0 * std::cos(w * t) + (rate0 + decay * e0) / w * std::sin(w * t));
}

// Walking at speed u under the force f: the distance e = x - w obeys m e'' + C e' + K e = f.
TEST(PersonTest, WalksAsTheEquationAndGivesWayToTheLeash) {
  const double u = 0.4, f = 30;
  TestRig<Person> rig(
      Params({{.activity = Activity::kWalk, .duration = 100, .speed = u, .direction = std::atan2(4, 3)}}));
  auto& person = rig.system();
  const Vec<3> across(-0.8, 0.6, 0);
  rig.Fix(person.leash, Pull(f, across));
  for (const double t : {0.1, 0.3, 0.7, 1.5, 10.0}) {
    rig.RunTo(t);
    const double along = u * t + Oscillator(kDamping, kStiffness, 0, -u, t);
    const double aside = f / kStiffness + Oscillator(kDamping, kStiffness, -f / kStiffness, 0, t);
    const Vec<3> p = Vec<3>(-1, 2, 0) + along * Vec<3>(0.6, 0.8, 0) + aside * across;
    EXPECT_THAT(rig[person.person].p_W, IsNear(p, 1e-8)) << t;
    EXPECT_THAT(rig[person.person].hand_W, IsNear(Vec<3>(p + Vec<3>(0, 0, 0.75)), 1e-8)) << t;
  }
  EXPECT_THAT(rig[person.person].v_W, IsNear(Vec<3>(0.24, 0.32, 0), 1e-8));
}

TEST(PersonTest, FollowsTheLeashOverGroundIfItIsTaut) {
  TestRig<Person> rig(Params({{.activity = Activity::kFollow, .duration = 100, .speed = 0.1}}));
  auto& person = rig.system();
  rig.Fix(person.leash, Pull(0, {0, 1, 0})).RunTo(10);
  EXPECT_THAT(rig[person.person].v_W, IsNear(Vec<3>(0, 0, 0), 1e-12));
  rig.Fix(person.leash, Pull(2, {0, 0.9, -std::sqrt(0.19)})).RunTo(20);
  EXPECT_THAT(rig[person.person].v_W, IsNear(Vec<3>(0, 0.04, 0), 1e-9)) << "2 N of 5 N";
  // Half the tension acts over ground: the speed is the same, the place is not.
  const Vec<3> before = rig[person.person].p_W;
  rig.Fix(person.leash, Pull(60, {-0.5, 0, std::sqrt(0.75)})).RunTo(40);
  EXPECT_THAT(rig[person.person].v_W, IsNear(Vec<3>(-0.1, 0, 0), 1e-9));
  EXPECT_NEAR(rig[person.motion].wanted[0] - rig[person.motion].x[0], 30 / kStiffness, 1e-9);
  EXPECT_NEAR(rig[person.person].p_W[0], before[0] - 20 * 0.1 - 30 / kStiffness, 1e-6);
  // Straight up there is nothing to follow.
  rig.Fix(person.leash, Pull(20, {0, 0, 1})).RunTo(60);
  EXPECT_THAT(rig[person.person].v_W, IsNear(Vec<3>(0, 0, 0), 1e-9));
}

// m v' = F - C v from rest; the wanted position moves along.
TEST(PersonTest, PullsAsTheEquation) {
  TestRig<Person> rig(
      Params({{.activity = Activity::kPull, .duration = 10, .direction = std::acos(-1.0), .force = 70}}));
  auto& person = rig.system();
  rig.Set(person.motion, {{0, 0}, {0, 0}, {0.1, 0.2}}).Fix(person.leash, Pull(0, {1, 0, 0}));
  for (const double t : {0.1, 0.5, 2.0, 8.0}) {
    rig.RunTo(t);
    const double v = 70 / kDamping * (1 - std::exp(-kDamping / kMass * t));
    const double x = 70 / kDamping * t - kMass / kDamping * v;
    EXPECT_THAT(rig[person.person].v_W, IsNear(Vec<3>(-v, 0, 0), 1e-8)) << t;
    EXPECT_THAT(rig[person.person].p_W, IsNear(Vec<3>(-x, 0, 0), 1e-8)) << t;
    const Vec<2> lean = rig[person.motion].wanted - rig[person.motion].x;
    EXPECT_THAT(lean, IsNear(Vec<2>(std::exp(-kStiffness / kDamping * t) * Vec<2>(0.1, 0.2)), 1e-8)) << t;
  }
  // Held by a leash that pulls as much, the person does not move.
  rig.Fix(person.leash, Pull(70, {1, 0, 0})).RunTo(10 - 0.01);
  EXPECT_THAT(rig[person.person].v_W, IsNear(Vec<3>(0, 0, 0), 1e-4));
}

TEST(PersonTest, GoesThroughItsPhasesThenStands) {
  // 0.1 + 0.2 + 0.3 is more than 0.6 in binary; each phase still ends at its tick.
  TestRig<Person> rig(Params({{.activity = Activity::kFollow, .duration = 0.1, .speed = 0.07},
                              {.activity = Activity::kWalk,
                               .duration = 0.2,
                               .speed = 0.08,
                               .speed_amplitude = 0.04,
                               .angular_frequency = 20,
                               .direction = 1},
                              {.activity = Activity::kPull, .duration = 0.3, .direction = -1, .force = 60}}));
  rig.Fix(rig->leash, Pull(0, {1, 0, 0}));
  for (int n = 0; n < 80; ++n) {
    const PersonIntent& intent = rig.Tick()[rig->intent];
    if (n < 10) {
      EXPECT_EQ(intent.activity, Activity::kFollow) << n;
      EXPECT_EQ(intent.speed, 0.07) << n;
    } else if (n < 30) {
      EXPECT_EQ(intent.activity, Activity::kWalk) << n;
      EXPECT_NEAR(intent.speed, 0.08 + 0.04 * std::sin(20 * (0.01 * n - 0.1)), 1e-6) << n;
      EXPECT_THAT(intent.direction_W, IsNear(Vec<2>(std::cos(1), std::sin(1)), 1e-12));
    } else if (n < 60) {
      EXPECT_EQ(intent.activity, Activity::kPull) << n;
      EXPECT_EQ(intent.force, 60) << n;
      EXPECT_EQ(intent.speed, 0) << n;
    } else {
      EXPECT_EQ(intent.activity, Activity::kWalk) << n;
      EXPECT_EQ(intent.speed, 0) << n;
      EXPECT_EQ(intent.force, 0) << n;
    }
  }
}

TEST(PersonTest, AcceleratesWithinItsLimit) {
  PersonParams params =
      Params({{.activity = Activity::kFollow, .duration = 1.5, .speed = 0.8},
              {.activity = Activity::kWalk, .duration = 0.5, .speed = 0.4, .direction = 1.5}});
  params.acceleration = 2;
  TestRig<Person> rig(params);
  const auto velocity = [&] { return rig.Tick()[rig->velocity]; };
  rig.Fix(rig->leash, Pull(10, {1, 0, 0}));
  for (int n = 1; n <= 50; ++n)
    EXPECT_THAT(velocity(), IsNear(Vec<2>(std::min(0.8, 0.02 * n), 0), 1e-12)) << n;
  rig.Fix(rig->leash, Pull(2.5, {1, 0, 0}));
  for (int n = 1; n <= 50; ++n)
    EXPECT_THAT(velocity(), IsNear(Vec<2>(std::max(0.4, 0.8 - 0.02 * n), 0), 1e-12))
        << n << ": half of the felt tension";
  rig.Fix(rig->leash, Pull(0, {1, 0, 0}));
  for (int n = 0; n < 50; ++n) velocity();
  EXPECT_EQ(rig[rig->velocity], Vec<2>(0, 0)) << "a slack leash leads nobody";
  EXPECT_EQ(rig[rig->intent].speed, 0.8);
  Vec<2> last = Vec<2>::Zero();
  for (int n = 0; n < 80; ++n) {
    const Vec<2> now = velocity();
    EXPECT_LT((now - last).norm(), 0.02 + 1e-12) << n;
    if (n == 40) EXPECT_THAT(now, IsNear(Vec<2>(0.4 * std::cos(1.5), 0.4 * std::sin(1.5)), 1e-12));
    last = now;
  }
  EXPECT_EQ(last, Vec<2>(0, 0)) << "and stands at the end, no faster";
  // The motion follows this velocity.
  params.phases = {{.activity = Activity::kFollow, .duration = 100, .speed = 0.8}};
  TestRig<Person> led(params);
  led.Fix(led->leash, Pull(10, {1, 0, 0})).RunTo(0.3);
  EXPECT_NEAR(led[led->motion].wanted[0] - params.start[0], 0.5 * 2 * 0.3 * 0.3, 0.02 * 0.3);
}

// A standing person on a taut leash to a fixed robot is an oscillator of both springs.
TEST(PersonTest, OscillatesOnTheLeash) {
  DiagramBuilder builder;
  PersonParams params = Params();
  params.start = {0, 0};
  auto& person = builder.Add<Person>("person", params);
  const LeashParams spring{
      .nominal_length = 1, .stiffness = 2000, .dissipation = 0, .attachment_B = {0, 0, 0}};
  auto& leash = builder.Add<Leash>("leash", spring);
  const LeggedState state{.p_WB = {1.1, 0, params.hand_height}};
  auto& robot = builder.Add<ConstantSource<LeggedState>>("robot", ConstantParams<LeggedState>{state});
  builder.Connect(robot.y, leash.robot);
  builder.Connect(person.person, leash.person);
  builder.Connect(leash.leash, person.leash);
  Simulator simulator(builder.Build(), {.order = 5, .rtol = 1e-10, .atol = 1e-12});
  const double rest = 2000 * 0.1 / (2000 + kStiffness);  // from where both springs are in balance
  simulator.context().Set(person.motion, {{rest, 0}, {0.1, 0}, {0, 0}});
  for (const double t : {0.05, 0.2, 0.5, 1.0}) {
    simulator.RunTo(t);
    const double e = Oscillator(kDamping, 2000 + kStiffness, 0, 0.1, t);
    EXPECT_THAT(simulator.context().Eval(person.person).p_W, IsNear(Vec<3>(rest + e, 0, 0), 1e-8)) << t;
    EXPECT_NEAR(simulator.context().Eval(leash.leash).tension, 2000 * (0.1 - rest - e), 1e-5) << t;
  }
}

TEST(PersonTest, IsDrawnWhereItIs) {
  TestRig<Person> rig(Params());
  const Geometry& shapes = rig[rig->geometry];
  for (const Shape& shape : shapes) {
    EXPECT_EQ(shape.role, ShapeRole::kOther);
    EXPECT_THAT(Vec<2>(shape.p_W.head<2>()), IsNear(Vec<2>(-1, 2), 1e-12)) << shape.name;
  }
  const Shape& body = shapes.at(0);
  EXPECT_NEAR(body.p_W[2] - body.size[1] / 2 - body.size[0], 0, 1e-12) << "stands on the ground";
}

TEST(PersonTest, RefusesNonsense) {
  const auto refuses =
      RefusesChanged<Person>(Params({{.activity = Activity::kWalk, .duration = 1, .speed = 0.1},
                                     {.activity = Activity::kPull, .duration = 1, .force = 60}}));
  EXPECT_TRUE(refuses([](auto& p) { p.phases[0].speed_amplitude = 0.2; }, "phases.0"));
  EXPECT_TRUE(refuses([](auto& p) { p.phases[1].speed = 1; }, "phases.1"));
  EXPECT_TRUE(refuses([](auto& p) { p.phases[0].force = 1; }, "phases.0"));
}

const LeashParams kParams{
    .nominal_length = 1.5, .stiffness = 120, .dissipation = 0.5, .attachment_B = {-0.3, 0.1, 0.2}};

LeggedState Robot(const Vec<3>& p_WB, const Vec<3>& rotation = Vec<3>::Zero()) {
  return {.p_WB = p_WB, .q_WB = QuaternionFromRotationVector(rotation)};
}

PersonState HandAt(const Vec<3>& hand_W) {
  return {.hand_W = hand_W};
}

TEST(LeashTest, IsASpringThatPullsOnly) {
  TestRig<Leash> rig(kParams);
  auto& leash = rig.system();
  // Turned by 90 degrees about z, B's (-0.3, 0.1, 0.2) is (-0.1, -0.3, 0.2) in W.
  rig.Fix(leash.robot, Robot({2.1, 0.3, 0.4}, {0, 0, std::acos(0.0)}));
  const Vec<3> attachment_W(2, 0, 0.6);
  const Vec<3> direction = Vec<3>(3, -1, 0.5).normalized();
  for (const double length : {0.2, 1.4999, 1.5, 1.5001, 1.75, 2.3}) {
    rig.Fix(leash.person, HandAt(attachment_W - length * direction));
    const double tension = length > 1.5 ? 120 * (length - 1.5) : 0;
    EXPECT_NEAR(rig[leash.leash].length, length, 1e-12);
    EXPECT_NEAR(rig[leash.leash].tension, tension, 1e-9) << length;
    EXPECT_THAT(rig[leash.leash].direction_W, IsNear(direction, 1e-12));
    const ExternalForce& force = rig[leash.force];
    EXPECT_EQ(force.body, 0);
    EXPECT_EQ(force.p_B, kParams.attachment_B);
    EXPECT_THAT(force.force_W, IsNear(Vec<3>(-tension * direction), 1e-9));
    EXPECT_TRUE(force.torque_W.isZero(0));
  }
}

// Damping is proportional to the rate of the length, here by finite differences of both positions.
TEST(LeashTest, DampsItsElongation) {
  TestRig<Leash> rig(kParams);
  auto& leash = rig.system();
  LeggedState robot = Robot({0.2, -0.1, 0.4}, {0.1, -0.2, 0.7});
  robot.v_W = {0.3, 0.2, -0.1};
  robot.w_W = {0.5, -1, 2};
  PersonState person = HandAt({-1.6, 0.3, 0.8});
  person.v_W = {-0.1, 0.25, 0};
  const auto at = [&](double t) {
    const Eigen::AngleAxisd turn(t * robot.w_W.norm(), robot.w_W.normalized());
    const Eigen::Vector3d end = robot.p_WB + t * robot.v_W + turn * robot.R_WB() * kParams.attachment_B;
    return (end - person.hand_W - t * person.v_W).norm();
  };
  const double rate = (at(1e-5) - at(-1e-5)) / 2e-5;
  ASSERT_GT(std::abs(rate), 0.1);
  rig.Fix(leash.robot, robot).Fix(leash.person, person);
  EXPECT_NEAR(rig[leash.leash].tension, 120 * (at(0) - 1.5) * (1 + 0.5 * rate), 1e-7);

  // If the ends approach so fast that the damping exceeds the spring, the leash is slack.
  person.v_W = 10 * rig[leash.leash].direction_W;
  rig.Fix(leash.person, person);
  EXPECT_EQ(rig[leash.leash].tension, 0);
}

TEST(LeashTest, AHandleAlsoPushes) {
  LeashParams params = kParams;
  params.handle = true;
  params.damping_time = 0.05;
  TestRig<Leash> rig(params);
  LeggedState robot = Robot({0, 0, 0.4});
  robot.v_W = {-0.3, 0.5, 0};
  for (const double length : {1.2, 1.5, 1.6}) {
    const Vec<3> attachment_W = robot.p_WB + kParams.attachment_B;
    rig.Fix(rig->robot, robot).Fix(rig->person, HandAt(attachment_W - Vec<3>(length, 0, 0)));
    const double tension = 120 * (length - 1.5 - 0.05 * 0.3);
    EXPECT_NEAR(rig[rig->leash].tension, tension, 1e-9) << length;
    EXPECT_THAT(rig[rig->force].force_W, IsNear(Vec<3>(-tension, 0, 0), 1e-9));
  }
}

TEST(LeashTest, EndsInOnePlaceDoNotPull) {
  TestRig<Leash> rig(kParams);
  auto& leash = rig.system();
  rig.Fix(leash.robot, Robot({0.3, -0.1, -0.2})).Fix(leash.person, HandAt({0, 0, 0}));
  EXPECT_NEAR(rig[leash.leash].length, 0, 1e-15);
  EXPECT_EQ(rig[leash.leash].tension, 0);
  EXPECT_TRUE(rig[leash.force].force_W.isZero(0));
}

TEST(LeashTest, IsDrawnFromTheHandToTheTrunkColouredByTension) {
  TestRig<Leash> rig(kParams);
  rig.Fix(rig->robot, Robot({2.3, -0.1, 0.4})).Fix(rig->person, HandAt({0.25, 0, 0.6}));
  const Shape& rod = rig[rig->geometry].at(0);
  EXPECT_EQ(rod.kind, ShapeKind::kSegment);
  EXPECT_EQ(rod.unit, "N");
  EXPECT_THAT(rod.p_W, IsNear(Vec<3>(0.25, 0, 0.6), 1e-12));
  EXPECT_THAT(Vec<3>(rod.p_W + rod.vector_W), IsNear(Vec<3>(2, 0, 0.6), 1e-12));
  EXPECT_NEAR(rod.value, 120 * 0.25, 1e-9);
}

}  // namespace tenon::person_test
