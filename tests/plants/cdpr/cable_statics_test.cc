#include <tenon/plants/cdpr/cable_statics.h>
#include <tenon/plants/model/swivel_pulley.h>
#include <tenon/tests/plants/model/cdpr_test_robots.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::cable_statics_test {

using test::FourCableRobot;

constexpr double kGravity = 9.81;

CableStatics At(const CdprDescription& robot, const Vec<3>& span_W, double rest_length) {
  return CalcCableStatics(robot, 0, span_W, rest_length, kGravity);
}

Vec<3> Pull(const CableStatics& cable) {
  return (cable.tension - cable.tension_loss) * cable.direction_W;
}

double Energy(const CableStatics& cable) {
  return cable.elastic_energy + cable.potential_energy;
}

Vec<3> RandomSpan(RandomStream& random) {
  return {random.Uniform(-5, 5), random.Uniform(-5, 5), random.Uniform(-2, 3)};
}

struct Kind {
  const char* name;
  double mass_per_length, pulley_radius;
};

class CableStaticsOfKinds : public ::testing::TestWithParam<Kind> {};
INSTANTIATE_TEST_SUITE_P(Cables, CableStaticsOfKinds,
                         ::testing::Values(Kind{"light", 0, 0}, Kind{"pulley", 0, 0.04},
                                           Kind{"heavy", 0.05, 0}, Kind{"very_heavy", 0.5, 0},
                                           Kind{"heavy_pulley", 0.05, 0.04}),
                         [](const auto& info) { return std::string(info.param.name); });

TEST_P(CableStaticsOfKinds, VirtualWorkGivesThePullAtBothEnds) {
  const CdprDescription robot = FourCableRobot(GetParam().mass_per_length, GetParam().pulley_radius);
  const double EA = robot.cable.axial_stiffness, w = robot.cable.mass_per_length * kGravity;
  RandomStream random(1);
  const double h = 1e-5;
  for (int i = 0; i < 20; ++i) {
    const Vec<3> span = RandomSpan(random);
    const double rest = span.norm() * random.Uniform(0.985, w > 0 ? 1.1 : 0.999);
    const CableStatics cable = At(robot, span, rest);
    Vec<3> gradient;
    for (int k = 0; k < 3; ++k) {
      const Vec<3> step = h * Vec<3>::Unit(k);
      gradient[k] = (Energy(At(robot, span + step, rest)) - Energy(At(robot, span - step, rest))) / (2 * h);
    }
    const double tolerance = 1e-6 + 1e-6 * cable.tension;
    // An attachment that moves by dp changes the span by -dp, and the cable pulls with -dE/dp.
    EXPECT_THAT(Pull(cable), IsNear(gradient, tolerance));
    // A piece dl0 that is let out has been strained by T, at the anchor's height.
    const double by_length =
        (Energy(At(robot, span, rest + h)) - Energy(At(robot, span, rest - h))) / (2 * h);
    const double expected =
        w * robot.cables[0].anchor_W[2] - cable.tension - cable.tension * cable.tension / (2 * EA);
    EXPECT_NEAR(by_length, expected, tolerance);
  }
}

TEST_P(CableStaticsOfKinds, TheElasticLengthIsThatOfItsStiffness) {
  const CdprDescription robot = FourCableRobot(GetParam().mass_per_length, GetParam().pulley_radius);
  RandomStream random(2);
  const double h = 1e-5;
  for (int i = 0; i < 20; ++i) {
    const Vec<3> span = RandomSpan(random);
    const CableStatics cable = At(robot, span, 0.99 * span.norm());
    const Vec<3> step = h * cable.direction_W;
    const double stiffness = cable.direction_W.dot(Pull(At(robot, span + step, 0.99 * span.norm())) -
                                                   Pull(At(robot, span - step, 0.99 * span.norm()))) /
                             (2 * h);
    EXPECT_NEAR(robot.cable.axial_stiffness / cable.elastic_length, stiffness, 1e-4 * stiffness);
  }
}

TEST_P(CableStaticsOfKinds, TheRestLengthGivesTheTension) {
  const CdprDescription robot = FourCableRobot(GetParam().mass_per_length, GetParam().pulley_radius);
  RandomStream random(3);
  for (int i = 0; i < 20; ++i) {
    const Vec<3> span = RandomSpan(random);
    const double tension = random.Uniform(40, 400);
    const double rest = CalcRestLength(robot, 0, span, tension, kGravity);
    EXPECT_NEAR(At(robot, span, rest).tension, tension, 1e-7);
    EXPECT_GT(rest, 0.97 * span.norm());
  }
}

TEST(CableStaticsTest, WithoutWeightAndPulleyItIsAStraightSpring) {
  const CableStatics cable = At(FourCableRobot(0, 0), {3, 0, 4}, 4.9);
  EXPECT_THAT(cable.direction_W, IsNear(Vec<3>(0.6, 0, 0.8), 1e-15));
  EXPECT_EQ(cable.length, 5);
  EXPECT_NEAR(cable.tension, 27e3 * 0.1 / 4.9, 1e-9);
  EXPECT_EQ(cable.tension_loss, 0);
  EXPECT_EQ(cable.elastic_length, 4.9);
  EXPECT_EQ(At(FourCableRobot(0, 0), {3, 0, 4}, 5.1).tension, 0);
  EXPECT_EQ(At(FourCableRobot(0.05, 0), {3, 0, 4}, 4.9).exit_W, FourCableRobot(0, 0).cables[0].anchor_W);
}

TEST(CableStaticsTest, SmallPulleysAndLightCablesConvergeToIt) {
  RandomStream random(4);
  for (int i = 0; i < 20; ++i) {
    const Vec<3> span = RandomSpan(random);
    const double rest = 0.99 * span.norm();
    const CableStatics ideal = At(FourCableRobot(0, 0), span, rest);
    for (const CdprDescription& robot :
         {FourCableRobot(0, 1e-9), FourCableRobot(1e-8, 0), FourCableRobot(1e-8, 1e-9)}) {
      const CableStatics cable = At(robot, span, rest);
      EXPECT_THAT(Pull(cable), IsNear(Pull(ideal), 1e-4));
      EXPECT_NEAR(cable.length, ideal.length, 1e-8);
      EXPECT_THAT(cable.exit_W, IsNear(ideal.exit_W, 1e-8));
    }
  }
}

TEST(CableStaticsTest, ASaggingCableLeavesItsPulleyTangentially) {
  const double r = 0.04;
  const CdprDescription robot = FourCableRobot(0.2, r);
  const Vec<3> anchor = robot.cables[0].anchor_W;
  RandomStream random(5);
  for (int i = 0; i < 20; ++i) {
    const Vec<3> span = RandomSpan(random);
    const CableStatics cable = At(robot, span, span.norm() * random.Uniform(0.99, 3));
    EXPECT_NEAR(cable.plane_W.dot(span.normalized()), -std::hypot(span[0], span[1]) / span.norm(), 1e-14);
    const Vec<3> spoke = cable.exit_W - anchor - r * cable.plane_W;
    EXPECT_NEAR(spoke.norm(), r, 1e-15);
    const Vec<3> end = cable.catenary.horizontal * cable.toward_W +
                       Vec<3>(0, 0, cable.catenary.vertical_end());  // on the pulley, away from the cable
    EXPECT_NEAR(spoke.dot(end.normalized()), 0, 1e-11 * r);
    EXPECT_GT(spoke.cross(end).dot(cable.plane_W.cross(Vec<3>(0, 0, 1))), 0);  // wrapped, not peeled off
    const Vec<2> reach = cable.catenary.PointAt(cable.catenary.rest_length);
    EXPECT_THAT(Vec<3>(anchor - span + reach[0] * cable.toward_W + Vec<3>(0, 0, reach[1])),
                IsNear(cable.exit_W, 1e-11));
  }
}

TEST(CableStaticsTest, RefusesImpossibleSpansAndLengths) {
  struct Case {
    double mass_per_length, pulley_radius;
    Vec<3> span_W;
    double rest_length;
  };
  for (const Case& c : {Case{0, 0, {0, 0, 0}, 1}, Case{0, 0, {1, 0, 0}, 0}, Case{0, 0.5, {0.3, 0, 0.1}, 1},
                        Case{0, 0.04, {0, 0, 3}, 1}, Case{0.05, 0.5, {3, 0, 2}, 0.1}}) {
    const CdprDescription robot = FourCableRobot(c.mass_per_length, c.pulley_radius);
    EXPECT_TRUE(Throws<RunError>([&] { At(robot, c.span_W, c.rest_length); }, "cable 0"))
        << c.span_W.transpose();
  }
  EXPECT_TRUE(Throws<RunError>(
      [] { CalcRestLength(FourCableRobot(1, 0), 0, 5 * Vec<3>::UnitX(), 10, kGravity); }, "cable 0", "10 N"));
}

}  // namespace tenon::cable_statics_test
