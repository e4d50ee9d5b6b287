#include <tenon/controllers/legged/comparison/sliding_mode.h>

#include <gtest/gtest.h>

namespace tenon {

// e'' = d - a from rest by the midpoint rule. In closed form s = s(0) - (k - d) t up to the layer, reached at
// t_r = (s(0) - phi) / (k - d); then s = d / kappa + (phi - d / kappa) exp(-kappa (t - t_r)).
TEST(SlidingModeTest, ReachesTheLayerInTimeAndSlidesAlongTheSurface) {
  const SlidingMode law{.slope = 8, .reach = 20, .layer = 0.01};
  const double phi = 0.08, k = 1.6, h = 1e-4;
  for (const double d : {0.0, 0.5, -0.5}) {
    const double reached = (8 * 0.3 - phi) / (k - d);
    Eigen::Vector3d e(0.3, -0.3, 0), rate(0, 0, 0);
    const Eigen::Vector3d push(d, -d, 0);
    for (int n = 0; n < 30000; ++n) {
      const double t = n * h;
      const double s =
          t < reached ? 8 * 0.3 - (k - d) * t : d / 20 + (phi - d / 20) * std::exp(-20 * (t - reached));
      ASSERT_NEAR(rate[0] + 8 * e[0], s, 1e-5) << t;
      ASSERT_NEAR(rate[1] + 8 * e[1], -s, 1e-5) << t;
      const Eigen::Vector3d e_half = e + h / 2 * rate,
                            rate_half = rate + h / 2 * (push - law.Acceleration(e, rate));
      e += h * rate_half;
      rate += h * (push - law.Acceleration(e_half, rate_half));
    }
    EXPECT_NEAR(e[0], d / 160, 5e-5);
  }
}

}  // namespace tenon
