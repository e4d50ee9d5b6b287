#include <tenon/systems/campaign/sampling.h>
#include <tenon/tests/testing/block_test.h>

#include <cmath>
#include <vector>

namespace tenon::sampling_test {

// The first points of the sequence: 1/2; 3/4, 1/4; 3/8, 3/8; ...
TEST(SobolTest, BeginsAsItDoes) {
  const auto points = Sobol(4, 2);
  EXPECT_EQ(points[0][0], 0.5);
  EXPECT_EQ(points[1][0], 0.5);
  EXPECT_EQ(points[0][1] + points[1][1], 1);
  EXPECT_EQ(std::abs(points[0][1] - points[1][1]), 0.5);
}

// In every dimension, 2^m points with the origin put equally many points into each of 64 equal intervals. The
// mean of a smooth function has a smaller error than with random points.
TEST(SobolTest, FillsEvenly) {
  const auto points = Sobol(1023, 5);
  double mean = 0;
  for (std::size_t k = 0; k < 1023; ++k) {
    double product = 1;
    for (const auto& coordinate : points) product *= 2 * coordinate[k];
    mean += product / 1023;
  }
  EXPECT_NEAR(mean, 1, 2e-2);
  for (const auto& coordinate : points) {
    std::multiset<int> intervals{0};
    for (const double x : coordinate) intervals.insert(static_cast<int>(64 * x));
    for (int i = 0; i < 64; ++i) EXPECT_EQ(intervals.count(i), 16U);
  }
}

TEST(SobolTest, OfNothingIsNothingAndDimensionsEnd) {
  EXPECT_TRUE(Sobol(10, 0).empty());
  EXPECT_TRUE(Throws<ParameterError>([] { Sobol(10, 100'000); }, "uniform"));
}

}  // namespace tenon::sampling_test
