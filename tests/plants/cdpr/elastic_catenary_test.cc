#include <tenon/plants/cdpr/cable_statics.h>
#include <tenon/plants/model/swivel_pulley.h>
#include <tenon/tests/plants/model/cdpr_test_robots.h>
#include <tenon/tests/testing/block_test.h>
#include <tenon/tests/testing/dense_algebra.h>

namespace tenon::elastic_catenary_test {

using test::FourCableRobot;

/// Taut and slack, light and heavy, stiff and soft.
ElasticCatenary Random(RandomStream& random) {
  const double x = random.Uniform(0.05, 8), z = random.Uniform(-6, 6);
  const double EA = std::pow(10, random.Uniform(3, 6)), w = std::pow(10, random.Uniform(-3, 1.5));
  const double stretch = random.Uniform(0, 1) < 0.5 ? random.Uniform(0.97, 1.03) : random.Uniform(1, 3);
  return HangCatenary(stretch * std::hypot(x, z), w, EA, x, z);
}

/// The tension at s.
Vec<2> Force(const ElasticCatenary& c, double s) {
  return {c.horizontal, c.vertical_start() + c.weight * s};
}

/// The integral of f(s) over the cable by Simpson's rule; intervals gather where the cable is lowest, and its
/// tension may be all but zero.
template <class F>
auto Integrate(const ElasticCatenary& c, const F& f) {
  const double low = std::clamp(-c.vertical_start() / c.weight, 0.0, c.rest_length);
  decltype(f(0.0)) sum = 0 * f(0.0);
  constexpr int kPieces = 3000;
  for (const double end : {0.0, c.rest_length}) {
    // s = low + (end - low) u^3
    for (int k = 0; k < kPieces; ++k) {
      for (const auto& [u, weight] : {std::pair{k + 0.0, 1.0}, {k + 0.5, 4.0}, {k + 1.0, 1.0}}) {
        const double v = u / kPieces;
        sum += weight / 6 / kPieces * 3 * v * v * std::abs(end - low) * f(low + (end - low) * v * v * v);
      }
    }
  }
  return sum;
}

TEST(ElasticCatenaryTest, ItsPiecesReachFromOneEndToTheOther) {
  RandomStream random(1);
  int taut = 0, slack = 0;
  for (int i = 0; i < 40; ++i) {
    const double x = random.Uniform(0.05, 8), z = random.Uniform(-6, 6), distance = std::hypot(x, z);
    const double EA = std::pow(10, random.Uniform(3, 6)), w = std::pow(10, random.Uniform(-3, 1.5));
    const double L = distance * (i % 2 == 0 ? random.Uniform(0.97, 1.03) : random.Uniform(1, 3));
    const ElasticCatenary c = HangCatenary(L, w, EA, x, z);
    ++(L < distance ? taut : slack);
    const Vec<2> reached = Integrate(c, [&](double s) -> Vec<2> {
      const Vec<2> force = Force(c, s);
      return (1 / EA + 1 / force.norm()) * force;
    });
    EXPECT_THAT(reached, IsNear(Vec<2>(x, z), 1e-7)) << "L = " << L << ", w = " << w << ", EA = " << EA;
    EXPECT_NEAR(c.tension_start, Force(c, 0).norm(), 1e-12 * c.tension_start);
    EXPECT_NEAR(c.tension_end, Force(c, L).norm(), 1e-12 * c.tension_end);
    EXPECT_THAT(c.PointAt(0), IsNear(Vec<2>(0, 0), 0));
    EXPECT_THAT(c.PointAt(L), IsNear(Vec<2>(x, z), 1e-12));
  }
  EXPECT_GT(taut, 5);
  EXPECT_GT(slack, 20);
}

TEST(ElasticCatenaryTest, LengthAndEnergiesAreIntegralsAlongIt) {
  RandomStream random(2);
  for (int i = 0; i < 20; ++i) {
    const ElasticCatenary c = Random(random);
    const double EA = c.axial_stiffness, middle = c.PointAt(c.rest_length)[1] / 2;
    const Eigen::Vector3d integrals = Integrate(c, [&](double s) -> Eigen::Vector3d {
      const double T = Force(c, s).norm();
      return {1 + T / EA, T * T / (2 * EA), c.weight * (c.PointAt(s)[1] - middle)};
    });
    EXPECT_NEAR(c.length, integrals[0], 1e-8 * c.length);
    EXPECT_NEAR(c.elastic_energy, integrals[1], 1e-7 * c.elastic_energy);
    EXPECT_NEAR(c.potential_energy, integrals[2], 1e-7 * c.weight * c.rest_length * c.rest_length);
  }
}

TEST(ElasticCatenaryTest, ForcesAreTheDerivativesOfTheEnergyAndStiffnessThatOfTheForces) {
  RandomStream random(3);
  for (int i = 0; i < 40; ++i) {
    const ElasticCatenary c = Random(random);
    const Vec<2> end = c.PointAt(c.rest_length);
    Vec<2> gradient;
    Eigen::Matrix2d stiffness;
    for (int k = 0; k < 2; ++k) {
      const double h = 1e-5 * end[0];
      ElasticCatenary side[2];
      for (const int s : {0, 1}) {
        Vec<2> moved = end;
        moved[k] += s == 0 ? -h : h;
        side[s] = HangCatenary(c.rest_length, c.weight, c.axial_stiffness, moved[0], moved[1]);
      }
      gradient[k] = (side[1].elastic_energy + side[1].potential_energy - side[0].elastic_energy -
                     side[0].potential_energy) /
                    (2 * h);
      stiffness.col(k) =
          Vec<2>(side[1].horizontal - side[0].horizontal, side[1].vertical - side[0].vertical) / (2 * h);
    }
    EXPECT_THAT(gradient, IsNear(Vec<2>(c.horizontal, c.vertical), 2e-5 * c.tension_end));
    EXPECT_THAT(c.stiffness, IsNear(stiffness, 2e-4 * c.stiffness.norm()));
  }
}

TEST(ElasticCatenaryTest, WithoutStretchItIsThePlainCatenary) {
  // z = a cosh(x / a), H = w a, T = w (z + ...) with a = 3 m, from x = -1 to 2.5 m.
  const double a = 3, w = 2, from = -1, to = 2.5;
  const double L = a * (std::sinh(to / a) - std::sinh(from / a));
  const ElasticCatenary c =
      HangCatenary(L, w, 1e13, to - from, a * (std::cosh(to / a) - std::cosh(from / a)));
  EXPECT_NEAR(c.horizontal, w * a, 1e-9);
  EXPECT_NEAR(c.tension_start, w * a * std::cosh(from / a), 1e-9);
  EXPECT_NEAR(c.tension_end, w * a * std::cosh(to / a), 1e-9);
  const double s = a * (std::sinh(1 / a) - std::sinh(from / a));
  EXPECT_THAT(c.PointAt(s), IsNear(Vec<2>(2, a * (std::cosh(1 / a) - std::cosh(from / a))), 1e-10));
}

TEST(ElasticCatenaryTest, WithoutWeightItIsTheStraightSpring) {
  const double EA = 27e3, L = 5, distance = 5.02, tension = EA * (distance / L - 1);
  const Vec<2> direction(0.6, 0.8);
  for (const double w : {1e-1, 1e-2, 1e-3, 1e-6, 1e-9, 1e-12}) {
    const ElasticCatenary c = HangCatenary(L, w, EA, distance * direction[0], distance * direction[1]);
    // The parabola's sag takes (w L cos)^2 / (24 T^2) of the length, of which strain makes tension.
    const double extra = EA * std::pow(w * L * 0.6 / tension, 2) / 24;
    const double off = (c.tension_start + c.tension_end) / 2 - tension;
    EXPECT_NEAR(off, extra, 0.05 * extra + 1e-9);
    EXPECT_THAT(Vec<2>(c.horizontal, c.vertical),
                IsNear(Vec<2>((tension + off) * direction), 2e-2 * w + 1e-8));
    const double less = 2 * extra / tension * EA / L;
    EXPECT_NEAR(direction.dot(c.stiffness * direction), EA / L - less, 0.05 * less + 1e-6);
  }
}

TEST(ElasticCatenaryTest, HangsStraightDownOrInAFold) {
  const double L = 4, w = 3, EA = 2000;
  // Its own weight stretches a cable that hangs from its end by w L^2 / (2 EA), a load P by P L / EA.
  const ElasticCatenary taut = HangCatenary(L, w, EA, 0, L + w * L * L / (2 * EA) + 50 * L / EA);
  EXPECT_NEAR(taut.tension_start, 50, 1e-8);
  EXPECT_NEAR(taut.tension_end, 50 + w * L, 1e-8);
  // Stiff, folded, with the ends 1 m above one another: 1.5 m and 2.5 m hang from them.
  const ElasticCatenary fold = HangCatenary(L, w, 1e12, 0, 1);
  EXPECT_NEAR(fold.tension_start, 1.5 * w, 1e-9);
  EXPECT_NEAR(fold.tension_end, 2.5 * w, 1e-9);
  EXPECT_NEAR(fold.horizontal, 0, 1e-9);
}

TEST(ElasticCatenaryTest, ACableUnderALoadIsDisplacedAsPublished) {
  // Michalos and Birnstiel, Movements of a cable due to changes in loading, J. Structural Division ASCE 86
  // (1960); also in Jayaraman and Knudson (1981): a cable over a span of 304.8 m sags by 29.276 m at
  // 121.92 m, where 35.586 kN move it by 5.626 m downwards and 0.859 m sideways. The lengths without strain,
  // published to 1 cm, move the sag by some cm and the displacement by some mm.
  const double EA = 131e9 * 548.4e-6, w = 46.12, span = 304.8;
  const auto at_rest = [&](double load) {
    Vec<2> p(121.92, -29.276);
    for (int i = 0; i < 50; ++i) {
      const ElasticCatenary left = HangCatenary(125.88, w, EA, p[0], -p[1]);
      const ElasticCatenary right = HangCatenary(186.85, w, EA, span - p[0], -p[1]);
      const Vec<2> missing(right.horizontal - left.horizontal,
                           left.vertical_start() + right.vertical_start() - load);
      Eigen::Matrix2d mirror = Vec<2>(-1, 1).asDiagonal();
      const Eigen::Matrix2d stiffness = mirror * left.stiffness * mirror + right.stiffness;
      const Vec<2> step = test::Solve(stiffness, Vec<2>(missing[0], missing[1]));
      p += Vec<2>(step[0], step[1]) * (step.norm() > 1 ? 1 / step.norm() : 1);
    }
    return p;
  };
  const Vec<2> before = at_rest(0), after = at_rest(35586);
  EXPECT_THAT(before, IsNear(Vec<2>(121.92, -29.276), 0.06));
  EXPECT_THAT(Vec<2>(after - before), IsNear(Vec<2>(-0.859, -5.626), 0.008));
}

TEST(ElasticCatenaryTest, IsFoundFromTautToSlack) {
  RandomStream random(4);
  int most = 0;
  for (int i = 0; i < 1000; ++i) {
    const double distance = std::pow(10, random.Uniform(-2, 3)), angle = random.Uniform(-1.5707, 1.5707);
    const double x = distance * std::cos(angle), z = distance * std::sin(angle);
    const double L = distance * (1 + std::pow(10, random.Uniform(-9, 1.5)) * (i % 3 == 0 ? -0.02 : 1));
    const double EA = std::pow(10, random.Uniform(2, 8)), w = std::pow(10, random.Uniform(-9, 2));
    if (L <= 0) continue;
    const ElasticCatenary c = HangCatenary(L, w, EA, x, z);
    ASSERT_THAT(c.PointAt(L), IsNear(Vec<2>(x, z), 1e-11 * (L + distance)));
    most = std::max(most, c.iterations);
  }
  EXPECT_LE(most, 60);
}

TEST(ElasticCatenaryTest, ANeighbourIsFoundInFewerStepsAndTheSame) {
  const ElasticCatenary c = HangCatenary(6.1, 0.5, 27e3, 5, 3.4);
  const ElasticCatenary cold = HangCatenary(6.1, 0.5, 27e3, 5.001, 3.4);
  const ElasticCatenary warm = HangCatenary(6.1, 0.5, 27e3, 5.001, 3.4, &c);
  EXPECT_NEAR(warm.horizontal, cold.horizontal, 1e-9);
  EXPECT_NEAR(warm.vertical, cold.vertical, 1e-9);
  EXPECT_LE(warm.iterations, cold.iterations);
}

TEST(ElasticCatenaryTest, RefusesImpossibleCables) {
  const auto refuses = [](double L, double w, double EA, double x, double z) {
    return Throws<RunError>([&] { HangCatenary(L, w, EA, x, z); });
  };
  EXPECT_TRUE(refuses(0, 1, 1e3, 1, 1));
  EXPECT_TRUE(refuses(1, 0, 1e3, 1, 1));
  EXPECT_TRUE(refuses(1, 1, -1e3, 1, 1));
  EXPECT_TRUE(refuses(1, 1, 1e3, -1, 1));
  EXPECT_TRUE(refuses(1, 1, 1e3, 1, NAN));
}

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

}  // namespace tenon::elastic_catenary_test
