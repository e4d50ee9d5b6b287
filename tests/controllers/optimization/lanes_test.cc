#include <tenon/controllers/optimization/lanes/small_product.h>
#include <tenon/tests/testing/block_test.h>

#include <random>

namespace tenon::internal::lanes_test {

/// The error of `value` in units in the last place.
double Units(double value, long double expected) {
  const double magnitude = std::abs(static_cast<double>(expected));
  const double unit = std::nextafter(magnitude, INFINITY) - magnitude;
  return static_cast<double>(std::abs(value - expected) / unit);
}

TENON_VECTOR_CLONES void SinesAndCosines(const double* angles, double* sines, double* cosines) {
  const Lanes angle = *PacketAt(angles);
  Lanes sine, cosine;
  SinCos(angle, &sine, &cosine);
  *PacketAt(sines) = sine;
  *PacketAt(cosines) = cosine;
}

TEST(Lanes, SineAndCosineOfAnyAngleUpToAMillion) {
  std::mt19937 generator(1);
  double worst = 0;
  for (int i = 0; i < 5000; ++i) {
    double angles[4], sines[4], cosines[4];
    int lane = 0;
    for (const double range : {0.8, 10.0, 1e3, 1e6}) {
      double angle = std::uniform_real_distribution<double>(-range, range)(generator);
      if (i % 5 == 0) angle = std::trunc(angle / M_PI_2) * M_PI_2;  // where one of them is nearly zero
      angles[lane++] = angle;
    }
    SinesAndCosines(angles, sines, cosines);
    for (int j = 0; j < 4; ++j) {
      const long double angle = angles[j];
      if (angle == 0) continue;
      ASSERT_TRUE(std::isfinite(sines[j]) && std::isfinite(cosines[j])) << angles[j];
      worst = std::max({worst, Units(sines[j], std::sin(angle)), Units(cosines[j], std::cos(angle))});
    }
  }
  EXPECT_LT(worst, 3);
}

TEST(Lanes, SineAndCosineOfLargeAnglesAreNotFinite) {
  const double infinity = INFINITY;
  double sines[4], cosines[4];
  for (const double angle : {1.1e6, -1.1e6, 1e300, infinity, std::nan("")}) {
    const double angles[4] = {0, angle, M_PI, -1e6};
    SinesAndCosines(angles, sines, cosines);
    EXPECT_TRUE(std::isnan(sines[1]) && std::isnan(cosines[1])) << angle;
    EXPECT_EQ(sines[0], 0);
    EXPECT_EQ(cosines[0], 1);
    EXPECT_EQ(cosines[2], -1);
    EXPECT_TRUE(std::isfinite(sines[3]) && std::isfinite(cosines[3]));
  }
}

TEST(Lanes, SquareRootsAreThoseOfTheLibrary) {
  const Lanes values = {2, 0, 1e-300, INFINITY};
  Lanes roots;
  Sqrt(values, &roots);
  for (int i = 0; i < 4; ++i) EXPECT_EQ(roots[i], std::sqrt(values[i]));
}

template <int rows, int columns>
void ExpectTransposed() {
  const Eigen::Matrix<double, rows, columns> A = Eigen::MatrixXd::Random(rows, columns);
  Eigen::Matrix<double, columns, rows> B;
  Transpose(A, B);
  EXPECT_EQ(B, A.transpose()) << rows << " x " << columns;
}

TEST(SmallProduct, TransposesMatricesOfAnySize) {
  ExpectTransposed<12, 16>();
  ExpectTransposed<12, 17>();
  ExpectTransposed<5, 12>();
  ExpectTransposed<7, 6>();
  ExpectTransposed<3, 2>();
  const Eigen::MatrixXd A = Eigen::MatrixXd::Random(12, 21);
  Eigen::MatrixXd B(21, 12);
  Transpose(A, B);
  EXPECT_EQ(B, A.transpose());
}

template <int size>
void ExpectMirrored() {
  const Eigen::MatrixXd given = Eigen::MatrixXd::Random(size, size);
  Eigen::Matrix<double, size, size> A = given;
  Mirror(A);
  for (int c = 0; c < size; ++c)
    for (int r = 0; r < size; ++r) EXPECT_EQ(A(r, c), r > c ? given(r, c) : given(c, r));
}

TEST(SmallProduct, MirrorsTheLowerTriangle) {
  ExpectMirrored<12>();
  ExpectMirrored<5>();
}

}  // namespace tenon::internal::lanes_test
