#include <tenon/controllers/legged/observers/disturbance_filter.h>
#include <tenon/tests/testing/block_test.h>

#include <algorithm>
#include <numbers>

namespace tenon::disturbance_filter_test {

Eigen::VectorXd AsVector(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

TEST(EstimatorGainsTest, ButterworthByPolynomial) {
  const double w = 40;
  EXPECT_THAT(AsVector(ButterworthGains(1, w)), IsNear(AsVector({w}), 1e-12));
  EXPECT_THAT(AsVector(ButterworthGains(3, w)), IsNear(AsVector({w / 2, w, 2 * w}), 1e-12));
  // (s^2 + w s + w^2) (s + w), and for order 2 s^2 + sqrt(2) w s + w^2.
  EXPECT_THAT(AsVector(GainsOfPolynomial({w * w * w, 2 * w * w, 2 * w})),
              IsNear(AsVector(ButterworthGains(3, w)), 1e-12));
  EXPECT_THAT(AsVector(GainsOfPolynomial({w * w, std::sqrt(2) * w})),
              IsNear(AsVector(ButterworthGains(2, w)), 1e-12));
}

TEST(EstimatorGainsTest, ButterworthPolesLieOnACircle) {
  for (int order = 1; order <= kMaxEstimatorOrder; ++order) {
    std::vector<double> angles;
    for (const auto& pole : EstimatorPoles(ButterworthGains(order, 7))) {
      EXPECT_NEAR(std::abs(pole), 7, 1e-6) << order;
      angles.push_back(std::arg(-pole));
    }
    std::sort(angles.begin(), angles.end());
    for (int k = 0; k < order; ++k)
      EXPECT_NEAR(angles[k], std::numbers::pi * (2 * k + 1 - order) / (2 * order), 1e-6);
  }
}

// The characteristic polynomial of three gains.
TEST(EstimatorGainsTest, PolesAreTheRootsOfThePolynomial) {
  const std::vector<double> gains{2.25, 6.28, 17.5};
  for (const auto& s : EstimatorPoles(gains)) {
    const auto p = s * s * s + gains[2] * s * s + gains[1] * gains[2] * s + gains[0] * gains[1] * gains[2];
    EXPECT_LT(std::abs(p), 1e-9);
    EXPECT_LT(s.real(), 0);
  }
}

TEST(EstimatorGainsTest, NoiseBandwidthInClosedForm) {
  const double w = 30;
  for (int order = 1; order <= 6; ++order)
    EXPECT_NEAR(NoiseBandwidth(ButterworthGains(order, w)),
                w / (4 * order * std::sin(std::numbers::pi / (2 * order))), 1e-9);
  // c_1 c_2 K_1 / (4 (c_1 c_2 - c_0)) for order 3.
  const double c0 = 2.25 * 6.28 * 17.5, c1 = 6.28 * 17.5, c2 = 17.5;
  EXPECT_NEAR(NoiseBandwidth({2.25, 6.28, 17.5}), 2.25 * c1 * c2 / (4 * (c1 * c2 - c0)), 1e-12);
}

TEST(EstimatorGainsTest, RefusesUnstableGains) {
  // Gains in reverse order, as a reader of the thesis may give them.
  const std::vector<double> reversed{17.5, 6.28, 2.25};
  EXPECT_TRUE(
      Throws<ParameterError>([&] { DemandHurwitz(reversed); }, "17.5, 6.28, 2.25", "2.01 ± 5.95i, -6.28"));
  for (const std::vector<double>& gains :
       {std::vector<double>{-1}, {0}, {}, std::vector<double>(13, 1.0), {1, NAN}})
    EXPECT_TRUE(Throws<ParameterError>([&] { DemandHurwitz(gains); }, "gain"));
  EXPECT_TRUE(Throws<ParameterError>([] { ButterworthGains(0, 1); }, "order", "0"));
  EXPECT_TRUE(Throws<ParameterError>([] { ButterworthGains(2, 0); }, "0 rad/s"));
  EXPECT_TRUE(Throws<ParameterError>([] { GainsOfPolynomial({1, 0}); }));
  EXPECT_TRUE(Throws<ParameterError>([] { NoiseBandwidth({-1}); }));
}

// Amplitude and phase for a sine, given by its mean over each interval; the error of the staircase is of
// order (w h)^2.
TEST(DisturbanceFilterTest, HasTheTransferFunction) {
  const std::vector<double> gains{2.25, 6.28, 17.5};
  const double h = 1e-3, w = 5;
  const DisturbanceFilter filter(gains, h);
  auto memory = filter.Start<2>();
  const std::complex<double> s(0, w);
  const std::complex<double> response =
      gains[0] * gains[1] * gains[2] /
      (s * s * s + gains[2] * s * s + gains[1] * gains[2] * s + gains[0] * gains[1] * gains[2]);
  for (int n = 1; n <= 10000; ++n) {
    const double mean = (std::cos(w * h * (n - 1)) - std::cos(w * h * n)) / (w * h);
    filter.Advance<2>(Vec<2>(mean, 0), &memory);
    if (n < 5000) continue;
    const double expected = (response * std::exp(s * (h * n))).imag();
    ASSERT_NEAR(DisturbanceFilter::Estimate<2>(memory)[0], expected, 1e-5) << n;
  }
}

// Two steps of half the interval equal one step of the interval, because the solution is exact.
TEST(DisturbanceFilterTest, StepsComposeExactly) {
  const std::vector<double> gains = ButterworthGains(4, 300);
  const DisturbanceFilter whole(gains, 4e-3), half(gains, 2e-3);
  auto once = whole.Start<2>(), twice = once;
  for (int n = 0; n < 20; ++n) {
    const Vec<2> f(std::sin(n), n % 3);
    whole.Advance<2>(f, &once);
    half.Advance<2>(f, &twice);
    half.Advance<2>(f, &twice);
    ASSERT_THAT(once, IsNear(twice, 1e-10));
  }
}

}  // namespace tenon::disturbance_filter_test
