#include <tenon/controllers/legged/observers/contact_aided_filter.h>
#include <tenon/tests/testing/block_test.h>
#include <tenon/tests/testing/dense_algebra.h>
#include <tenon/tests/testing/derivative_check.h>

#include <Eigen/Geometry>

namespace tenon::contact_aided_filter_test {

using Filter = ContactAidedFilter;
constexpr double kPeriod = 1e-3, kRadius = 0.03, kGravity = 9.81;
constexpr std::array<bool, kNumLegs> kAll{true, true, true, true};

Vec<3> Normal(RandomStream& random, double deviation) {
  return {deviation * random.Normal(), deviation * random.Normal(), deviation * random.Normal()};
}

ContactAidedMean RandomMean(RandomStream& random) {
  ContactAidedMean mean{.p_WI = Normal(random, 1),
                        .v_WI = Normal(random, 1),
                        .q_WB = QuaternionFromRotationVector(Normal(random, 1)),
                        .specific_force_bias_B = Normal(random, 0.1),
                        .angular_velocity_bias_B = Normal(random, 0.1)};
  for (Vec<3>& foot : mean.feet_W) foot = Normal(random, 1);
  return mean;
}

ContactAidedInput RandomInput(RandomStream& random) {
  ContactAidedInput input{{Normal(random, 3), Normal(random, 10)}, {}};
  for (Vec<3>& turn : input.turn_B) turn = Normal(random, 0.01);
  return input;
}

/// The error that Plus adds to `mean` to give `other`.
Filter::Error Difference(const ContactAidedMean& other, const ContactAidedMean& mean) {
  Filter::Error error;
  const Eigen::AngleAxisd turn(other.R_WB() * mean.R_WB().transpose());
  error.segment<3>(Filter::kPosition) = other.p_WI - turn * mean.p_WI;
  error.segment<3>(Filter::kVelocity) = other.v_WI - turn * mean.v_WI;
  error.segment<3>(Filter::kAttitude) = turn.angle() * turn.axis();
  error.segment<3>(Filter::kForceBias) = other.specific_force_bias_B - mean.specific_force_bias_B;
  error.segment<3>(Filter::kRateBias) = other.angular_velocity_bias_B - mean.angular_velocity_bias_B;
  for (std::size_t leg = 0; leg < kNumLegs; ++leg)
    error.segment<3>(Filter::kFeet + 3 * static_cast<int>(leg)) = other.feet_W[leg] - turn * mean.feet_W[leg];
  return error;
}

/// The derivative of a foot's residual.
Filter::FootRow FootRow(int leg) {
  Filter::FootRow H = Filter::FootRow::Zero();
  H.middleCols<3>(Filter::kPosition) = -Eigen::Matrix3d::Identity();
  H.middleCols<3>(Filter::kFeet + 3 * leg).setIdentity();
  return H;
}

Filter::Covariance RandomCovariance(RandomStream& random, double size) {
  Filter::Covariance root;
  for (int i = 0; i < Filter::kErrors; ++i)
    for (int j = 0; j < Filter::kErrors; ++j) root(i, j) = size * random.Normal();
  return root * root.transpose();
}

TEST(ContactAidedFilterTest, JacobiansAreThoseOfFiniteDifferences) {
  RandomStream random(1);
  for (int i = 0; i < 5; ++i) {
    const ContactAidedMean mean = RandomMean(random);
    const ContactAidedInput input = RandomInput(random);
    const ContactAidedMean next = Propagate(mean, input, kAll, kPeriod, kRadius, kGravity);
    const auto propagate = [&](const Filter::Error& error) -> Eigen::VectorXd {
      return Difference(Propagate(Plus(mean, error), input, kAll, kPeriod, kRadius, kGravity), next);
    };
    const Filter::Error zero = Filter::Error::Zero();
    EXPECT_TRUE(IsJacobian(PropagationJacobian(mean, input, kAll, kPeriod, kRadius, kGravity), propagate,
                           zero, 1e-8));

    for (int leg = 0; leg < kNumLegs; ++leg) {
      const Vec<3> place = mean.R_WB().transpose() * (mean.feet_W[leg] - mean.p_WI);
      const auto residual = [&](const Filter::Error& error) -> Eigen::VectorXd {
        return FootResidual(Plus(mean, error), leg, place);
      };
      EXPECT_TRUE(IsJacobian(FootRow(leg), residual, zero, 1e-8));
    }
  }
}

// Correction by one foot after the other equals Kalman's formula for all feet together.
TEST(ContactAidedFilterTest, CorrectionIsKalmans) {
  RandomStream random(2);
  Filter filter;
  filter.mean = RandomMean(random);
  filter.anchored = {true, false, true, true};
  filter.covariance = RandomCovariance(random, 0.01);
  filter.Release(1);
  std::array<FootMeasurement, kNumLegs> feet;
  Eigen::Matrix<double, 9, Filter::kErrors> H;
  Eigen::Matrix<double, 9, 9> N = Eigen::Matrix<double, 9, 9>::Zero();
  Vec<9> innovation;
  int row = 0;
  const Eigen::Matrix3d R = filter.mean.R_WB();
  for (int leg = 0; leg < kNumLegs; ++leg) {
    FootMeasurement& foot = feet[leg];
    const Vec<3> arm = filter.mean.feet_W[leg] - filter.mean.p_WI;
    foot.p_IF_B = R.transpose() * arm + Normal(random, 0.01);
    foot.covariance = Vec<3>(1e-4, 2e-4, 3e-4).asDiagonal();
    if (leg == 1) continue;
    H.middleRows<3>(row) = FootRow(leg);
    N.block<3, 3>(row, row) = R * foot.covariance * R.transpose();
    innovation.segment<3>(row) = -FootResidual(filter.mean, leg, foot.p_IF_B);
    row += 3;
  }
  const Eigen::MatrixXd P = filter.covariance;
  const Eigen::MatrixXd gain = P * H.transpose() * test::Inverse(H * P * H.transpose() + N);
  const Filter::Error error = gain * innovation;
  const ContactAidedMean expected = Plus(filter.mean, error);

  EXPECT_EQ(filter.Correct(feet, 1e9), 0);
  EXPECT_THAT(Difference(filter.mean, expected), IsNear(Filter::Error(Filter::Error::Zero()), 1e-11));
  EXPECT_THAT(Eigen::MatrixXd(filter.covariance), IsNear(Eigen::MatrixXd(P - gain * H * P), 1e-12));
}

// Anchoring a foot is the limit of a correction with unlimited prior covariance of the foot.
TEST(ContactAidedFilterTest, AnchoringIsMeasuringAFootOfUnknownPlace) {
  RandomStream random(3);
  Filter filter;
  filter.mean = RandomMean(random);
  filter.covariance = RandomCovariance(random, 0.01);
  for (int leg = 0; leg < kNumLegs; ++leg) filter.Release(leg);
  const FootMeasurement foot{Normal(random, 0.3), Vec<3>(1e-4, 2e-4, 3e-4).asDiagonal()};
  Filter measured = filter;
  measured.anchored[2] = true;
  const int rows = Filter::kFeet + 6;
  measured.covariance.block<3, 3>(rows, rows).diagonal().setConstant(1e4);
  std::array<FootMeasurement, kNumLegs> feet;
  feet[2] = foot;
  measured.Correct(feet, 1e9);

  filter.Anchor(2, foot);
  EXPECT_THAT(Difference(filter.mean, measured.mean), IsNear(Filter::Error(Filter::Error::Zero()), 1e-6));
  EXPECT_THAT(Eigen::MatrixXd(filter.covariance), IsNear(Eigen::MatrixXd(measured.covariance), 1e-6));
}

// A foot that rolls by an angle moves by radius times angle.
TEST(ContactAidedFilterTest, AFootRollsWithItsShank) {
  ContactAidedMean mean;
  ContactAidedInput input{{{0, 2, 0}, {0, 0, kGravity}}, {}};
  input.turn_B.fill(Vec<3>(0, 0.01, 0));
  input.turn_B[1] = {0.01, 0, 0};
  const ContactAidedMean next = Propagate(mean, input, {true, true, false, true}, kPeriod, kRadius, kGravity);
  EXPECT_THAT(next.feet_W[0], IsNear(Vec<3>(0.012 * kRadius, 0, 0), 1e-15));
  EXPECT_THAT(next.feet_W[1], IsNear(Vec<3>(0.002 * kRadius, -0.01 * kRadius, 0), 1e-15));
  EXPECT_EQ(next.feet_W[2], mean.feet_W[2]);
}

// A spinning body in free flight: a parabola and a turn about a body axis. The sensors measure their biases
// and the turn.
TEST(ContactAidedFilterTest, AThrownBodyFliesAParabola) {
  RandomStream random(6);
  ContactAidedMean mean = RandomMean(random);
  const ContactAidedMean start = mean;
  const Vec<3> w_B(2, -3, 1);
  ContactAidedInput input{{w_B + start.angular_velocity_bias_B, start.specific_force_bias_B}, {}};
  input.turn_B.fill(Vec<3>::Zero());
  for (int k = 0; k < 700; ++k) mean = Propagate(mean, input, {}, kPeriod, kRadius, kGravity);
  const double t = 0.7;
  EXPECT_THAT(mean.p_WI, IsNear(start.p_WI + t * start.v_WI - Vec<3>(0, 0, kGravity * t * t / 2), 1e-10));
  EXPECT_THAT(mean.v_WI, IsNear(start.v_WI - Vec<3>(0, 0, kGravity * t), 1e-10));
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(t * w_B.norm(), w_B.normalized()).toRotationMatrix();
  EXPECT_THAT(Eigen::Matrix3d(mean.R_WB()), IsNear(Eigen::Matrix3d(start.R_WB() * turn), 1e-10));
}

/// A trunk that sways a few centimetres and nods and turns a few degrees, in closed form.
struct Sway {
  explicit Sway(double t)
      : p(3 + 0.028 * std::sin(6 * t), 2 + 0.025 * std::sin(9 * t), 0.4 + 0.01 * std::sin(8 * t)),
        v(0.168 * std::cos(6 * t), 0.225 * std::cos(9 * t), 0.08 * std::cos(8 * t)),
        a(-1.008 * std::sin(6 * t), -2.025 * std::sin(9 * t), -0.64 * std::sin(8 * t)) {
    const double yaw = 0.3 * t, nod = 0.08 * std::sin(7 * t), nod_rate = 0.56 * std::cos(7 * t);
    R << Eigen::AngleAxisd(yaw, Vec<3>::UnitZ()) * Eigen::AngleAxisd(nod, Vec<3>::UnitY()).toRotationMatrix();
    w_B = R.transpose() * Vec<3>(-std::sin(yaw) * nod_rate, std::cos(yaw) * nod_rate, 0.3);
  }
  Vec<3> p, v, a, w_B;
  Eigen::Matrix3d R;
};

// In 60 runs with noise of all kinds the error squared and weighted with the inverse covariance has the mean
// of chi-square, the number of degrees of freedom. The mean over runs of the velocity's has a standard
// deviation of sqrt(2 * 3 / 60), that of the tilt's sqrt(2 * 2 / 60).
TEST(ContactAidedFilterTest, KnowsHowGoodItIs) {
  ContactAidedNoise noise;  // of poor sensors, so that each of them counts
  noise.specific_force = 2;
  noise.angular_velocity = 0.2;
  noise.specific_force_bias_walk = 0.3;
  noise.angular_velocity_bias_walk = 0.03;
  constexpr int kRuns = 60, kTicks = 1500;
  double velocity = 0, tilt = 0, rate = 0, force = 0;
  for (int run = 0; run < kRuns; ++run) {
    RandomStream random(static_cast<std::uint64_t>(run) + 10);
    const Vec<5> deviation(1e-3, 0.05, 0.02, 0.1, 0.01);
    const Sway start(0);
    ContactAidedMean guess{.p_WI = start.p + Normal(random, deviation[0]),
                           .v_WI = start.v + Normal(random, deviation[1])};
    guess.q_WB = QuaternionProduct(QuaternionFromRotationVector(Normal(random, deviation[2])),
                                   QuaternionFromRotation(start.R));
    Vec<3> force_bias = Normal(random, deviation[3]), rate_bias = Normal(random, deviation[4]);
    std::array<Vec<3>, kNumLegs> feet_W{Vec<3>(3.3, 2.2, 0), Vec<3>(3.3, 1.8, 0), Vec<3>(2.7, 2.2, 0),
                                        Vec<3>(2.7, 1.8, 0)};
    const auto measure = [&](const Sway& trunk) {
      std::array<FootMeasurement, kNumLegs> feet;
      for (std::size_t leg = 0; leg < kNumLegs; ++leg) {
        feet[leg].p_IF_B = trunk.R.transpose() * (feet_W[leg] - trunk.p) + Normal(random, noise.foot);
        feet[leg].covariance = noise.foot * noise.foot * Eigen::Matrix3d::Identity();
      }
      return feet;
    };
    Filter filter;
    filter.Start(guess, deviation);
    const auto first = measure(start);
    for (int leg = 0; leg < kNumLegs; ++leg) filter.Anchor(leg, first[leg]);
    for (int k = 0; k < kTicks; ++k) {
      const Sway trunk(kPeriod * k);
      ContactAidedInput input;
      for (Vec<3>& turn : input.turn_B) turn.setZero();
      input.inertial.specific_force_B = trunk.R.transpose() * (trunk.a + Vec<3>(0, 0, kGravity)) +
                                        force_bias + Normal(random, noise.specific_force);
      input.inertial.angular_velocity_B = trunk.w_B + rate_bias + Normal(random, noise.angular_velocity);
      filter.Predict(input, noise, kPeriod, 0, kGravity);
      for (Vec<3>& at : feet_W) at += Normal(random, std::sqrt(kPeriod) * noise.foot_walk);
      force_bias += Normal(random, std::sqrt(kPeriod) * noise.specific_force_bias_walk);
      rate_bias += Normal(random, std::sqrt(kPeriod) * noise.angular_velocity_bias_walk);
      EXPECT_EQ(filter.Correct(measure(Sway(kPeriod * (k + 1))), 40), 0);
    }
    EXPECT_GT(test::SymmetricModes(filter.covariance).eigenvalues[0], 0);
    const Sway end(kPeriod * kTicks);
    const Eigen::AngleAxisd turn(end.R * filter.mean.R_WB().transpose());
    const auto weigh = [](const Eigen::VectorXd& error, const Eigen::MatrixXd& P) {
      return error.dot(test::Solve(P, error).col(0)) / kRuns;
    };
    velocity += weigh(Vec<3>(end.v - filter.mean.v_WI), filter.VelocityCovariance());
    tilt += weigh(Vec<2>((turn.angle() * turn.axis()).head<2>()),
                  Eigen::Matrix2d(filter.covariance.block<2, 2>(Filter::kAttitude, Filter::kAttitude)));
    const auto block = [&](int at) { return Eigen::Matrix3d(filter.covariance.block<3, 3>(at, at)); };
    rate += weigh(Vec<3>(rate_bias - filter.mean.angular_velocity_bias_B), block(Filter::kRateBias));
    force += weigh(Vec<3>(force_bias - filter.mean.specific_force_bias_B), block(Filter::kForceBias));
  }
  EXPECT_NEAR(velocity, 3, 3 * std::sqrt(6.0 / kRuns));
  EXPECT_NEAR(tilt, 2, 3 * std::sqrt(4.0 / kRuns));
  EXPECT_NEAR(rate, 3, 3 * std::sqrt(6.0 / kRuns));
  EXPECT_NEAR(force, 3, 3 * std::sqrt(6.0 / kRuns));
}

TEST(ContactAidedFilterTest, AFootThatIsNotAnchoredHasNoCovariance) {
  RandomStream random(5);
  Filter filter;
  filter.mean = RandomMean(random);
  filter.covariance = RandomCovariance(random, 0.01);
  filter.anchored = kAll;
  filter.Release(3);
  filter.Predict(RandomInput(random), {}, kPeriod, kRadius, kGravity);
  EXPECT_EQ(filter.covariance.bottomRows<3>().cwiseAbs().maxCoeff(), 0);
  EXPECT_EQ(filter.covariance.rightCols<3>().cwiseAbs().maxCoeff(), 0);
  EXPECT_GT((filter.covariance.block<3, 3>(Filter::kFeet + 6, 0).norm()), 0);
}

}  // namespace tenon::contact_aided_filter_test
