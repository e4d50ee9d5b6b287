#include <tenon/systems/analysis/lqr.h>
#include <tenon/systems/analysis/matrix_functions.h>
#include <tenon/tests/testing/block_test.h>
#include <tenon/tests/testing/dense_algebra.h>

namespace tenon::lqr_test {

using Eigen::Matrix2d, Eigen::MatrixXd, Eigen::Vector2d;

const MatrixXd kOne = MatrixXd::Ones(1, 1);

MatrixXd Random(Eigen::Index rows, Eigen::Index cols, RandomStream& random) {
  return MatrixXd::NullaryExpr(rows, cols, [&] { return random.Uniform(-1, 1); });
}

/// A random problem with mostly unstable modes, and states scaled by factors from 10^-span to 10^span.
struct Problem {
  Problem(int n, int m, std::uint64_t seed, double span = 2) {
    RandomStream random(seed);
    const Eigen::VectorXd scale =
        Eigen::VectorXd::NullaryExpr(n, [&] { return std::pow(10, random.Uniform(-span, span)); });
    A = scale.asDiagonal() * Random(n, n, random) * scale.cwiseInverse().asDiagonal();
    B = scale.asDiagonal() * Random(n, m, random);
    const MatrixXd all = Random(n + m, n + m, random);
    const MatrixXd cost = all * all.transpose();
    Q = scale.cwiseInverse().asDiagonal() * cost.topLeftCorner(n, n) * scale.cwiseInverse().asDiagonal();
    N = scale.cwiseInverse().asDiagonal() * cost.topRightCorner(n, m);
    R = cost.bottomRightCorner(m, m);
  }
  MatrixXd A, B, Q, R, N;
};

Matrix2d DoubleIntegrator() {
  return (Matrix2d() << 0, 1, 0, 0).finished();
}

TEST(LqrTest, DoubleIntegrator) {
  const LqrDesign design = Lqr(DoubleIntegrator(), Vector2d(0, 1), Matrix2d::Identity(), kOne);
  const double sqrt3 = std::sqrt(3);
  EXPECT_THAT(design.K, IsNear(Eigen::RowVector2d(1, sqrt3), 1e-13));
  EXPECT_THAT(design.S, IsNear((Matrix2d() << sqrt3, 1, 1, sqrt3).finished(), 1e-13));
}

TEST(LqrTest, ScalarsInClosedForm) {
  // 2 a s - b² s²/r + q = 0.
  const double a = 3, b = 0.5, q = 2, r = 0.1;
  const double s = r / (b * b) * (a + std::sqrt(a * a + b * b * q / r));
  const LqrDesign design = Lqr(a * kOne, b * kOne, q * kOne, r * kOne);
  EXPECT_NEAR(design.S(0, 0), s, 1e-12 * s);
  EXPECT_NEAR(design.K(0, 0), b * s / r, 1e-12 * b * s / r);
  // s² = s + 1.
  EXPECT_NEAR(DiscreteLqr(kOne, kOne, kOne, kOne).S(0, 0), (1 + std::sqrt(5)) / 2, 1e-14);
}

TEST(LqrTest, RiccatiEquationHoldsAndTheLoopIsStable) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const Problem p(12, 3, seed);
    const LqrDesign design = Lqr(p.A, p.B, p.Q, p.R, p.N);
    const MatrixXd& S = design.S;
    const MatrixXd gain = test::Solve(p.R, p.B.transpose() * S + p.N.transpose());
    const MatrixXd residual = p.A.transpose() * S + S * p.A - (S * p.B + p.N) * gain + p.Q;
    EXPECT_LT(residual.norm(), 1e-9 * (2 * (S * p.A).norm() + p.Q.norm())) << seed;
    EXPECT_THAT(design.K, IsNear(gain, 1e-12 * gain.norm()));
    EXPECT_EQ(S, S.transpose());
    EXPECT_LT(test::Eigenvalues(p.A - p.B * design.K).real().maxCoeff(), 0);
  }
}

TEST(LqrTest, DiscreteRiccatiEquationHoldsAndTheLoopIsStable) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const Problem p(12, 3, seed);
    const LqrDesign design = DiscreteLqr(p.A, p.B, p.Q, p.R, p.N);
    const MatrixXd& S = design.S;
    const MatrixXd gain =
        test::Solve(p.R + p.B.transpose() * S * p.B, p.B.transpose() * S * p.A + p.N.transpose());
    const MatrixXd residual = p.A.transpose() * S * p.A - (p.A.transpose() * S * p.B + p.N) * gain + p.Q - S;
    EXPECT_LT(residual.norm(), 1e-9 * (p.A.transpose() * S * p.A).norm()) << seed;
    EXPECT_THAT(design.K, IsNear(gain, 1e-12 * gain.norm()));
    EXPECT_LT(test::Eigenvalues(p.A - p.B * design.K).cwiseAbs().maxCoeff(), 1);
  }
}

TEST(LqrTest, SizesOfAllKinds) {
  // Decoupled springs from soft to stiff, with forces in different units.
  const int n = 6;
  MatrixXd A = MatrixXd::Zero(2 * n, 2 * n), B = MatrixXd::Zero(2 * n, n);
  for (int i = 0; i < n; ++i) {
    const double w = std::pow(10, i - 2);  // 1/s
    A(i, n + i) = 1;
    A(n + i, i) = -w * w;
    B(n + i, i) = std::pow(10, 3 - i);
  }
  const MatrixXd Q = MatrixXd::Identity(2 * n, 2 * n), R = 1e-3 * MatrixXd::Identity(n, n);
  const LqrDesign design = Lqr(A, B, Q, R);
  for (int i = 0; i < n; ++i) {
    // In closed form: s12 = (sqrt(w⁴ + g) - w²) / g with g = b²/r, and s22 = sqrt((2 s12 + 1) / g).
    const double w2 = -A(n + i, i), g = B(n + i, i) * B(n + i, i) / 1e-3;
    const double s12 = 1 / (std::sqrt(w2 * w2 + g) + w2), s22 = std::sqrt((2 * s12 + 1) / g);
    EXPECT_NEAR(design.S(i, n + i) / s12, 1, 1e-5) << i;
    EXPECT_NEAR(design.S(n + i, n + i) / s22, 1, 1e-5) << i;
  }
}

TEST(LqrTest, ForcesOfTwoSizes) {
  const MatrixXd R = Vector2d(1e10, 1e-8).asDiagonal();
  const LqrDesign design = Lqr(Matrix2d::Zero(), Matrix2d::Identity(), Matrix2d::Identity(), R);
  EXPECT_THAT(design.K, IsNear(Vector2d(1e-5, 1e4).asDiagonal().toDenseMatrix(), 1e-9));
}

TEST(LqrTest, WhatDecaysNeedNeitherForceNorWeight) {
  const Matrix2d A = Vector2d(-1, 2).asDiagonal();
  const Matrix2d Q = Vector2d(0, 1).asDiagonal();
  const LqrDesign design = Lqr(A, Vector2d(0, 1), Q, kOne);
  EXPECT_THAT(design.K, IsNear(Eigen::RowVector2d(0, 2 + std::sqrt(5)), 1e-12));
  const Matrix2d discrete = Vector2d(0.5, 2).asDiagonal();
  EXPECT_EQ(DiscreteLqr(discrete, Vector2d(0, 1), Q, kOne).K(0, 0), 0);
}

TEST(LqrTest, KalmanFilterOfARandomWalk) {
  // dP/dt = q - P²/r.
  const KalmanDesign design = Kalman(0 * kOne, kOne, 9 * kOne, 4 * kOne);
  EXPECT_NEAR(design.P(0, 0), 6, 1e-13);
  EXPECT_NEAR(design.L(0, 0), 1.5, 1e-13);
  // P = P - P²/(P + r) + q: P² - q P - q r = 0.
  const KalmanDesign discrete = DiscreteKalman(kOne, kOne, 9 * kOne, 4 * kOne);
  const double P = (9 + std::sqrt(81 + 4 * 36)) / 2;
  EXPECT_NEAR(discrete.P(0, 0), P, 1e-13);
  EXPECT_NEAR(discrete.L(0, 0), P / (P + 4), 1e-13);
}

TEST(LqrTest, KalmanEquationsHoldAndErrorsDecay) {
  const Problem p(8, 2, 3);  // and its dual
  const MatrixXd A = p.A.transpose(), C = p.B.transpose();
  const KalmanDesign design = Kalman(A, C, p.Q, p.R);
  const MatrixXd& P = design.P;
  EXPECT_LT((A * P + P * A.transpose() - design.L * p.R * design.L.transpose() + p.Q).norm(),
            1e-9 * (A * P).norm());
  EXPECT_LT(test::Eigenvalues(A - design.L * C).real().maxCoeff(), 0);

  const KalmanDesign discrete = DiscreteKalman(A, C, p.Q, p.R);
  const MatrixXd after = (MatrixXd::Identity(8, 8) - discrete.L * C) * discrete.P;
  EXPECT_THAT(A * after * A.transpose() + p.Q, IsNear(discrete.P, 1e-9 * discrete.P.norm()));
  EXPECT_LT(test::Eigenvalues(A - A * discrete.L * C).cwiseAbs().maxCoeff(), 1);
}

::testing::AssertionResult Refuses(const std::function<void()>& design, const char* what,
                                   const char* matrices) {
  return Throws<ParameterError>(design, what, matrices);
}

TEST(LqrTest, SizesAreChecked) {
  const MatrixXd A = DoubleIntegrator(), B = Vector2d(0, 1), Q = Matrix2d::Identity();
  EXPECT_TRUE(Refuses([&] { Lqr(B, B, Q, kOne); }, "Lqr", "A is 2 x 1, but should be 2 x 2"));
  EXPECT_TRUE(Refuses([&] { Lqr({}, B, Q, kOne); }, "Lqr", "A is 0 x 0"));
  EXPECT_TRUE(Refuses([&] { Lqr(A, kOne, Q, kOne); }, "Lqr", "B is 1 x 1"));
  EXPECT_TRUE(Refuses([&] { Lqr(A, B, kOne, kOne); }, "Lqr", "Q is 1 x 1"));
  EXPECT_TRUE(Refuses([&] { DiscreteLqr(A, B, Q, Q); }, "DiscreteLqr", "R is 2 x 2"));
  EXPECT_TRUE(Refuses([&] { Lqr(A, B, Q, kOne, kOne); }, "Lqr", "N is 1 x 1"));
  EXPECT_TRUE(Refuses([&] { Kalman(A, B, Q, kOne); }, "Kalman", "C is 2 x 1"));
  EXPECT_TRUE(Refuses([&] { DiscreteKalman(A, B.transpose(), Q, Q); }, "DiscreteKalman", "R is 2 x 2"));
  EXPECT_TRUE(Refuses([&] { Lqr(A, B * NAN, Q, kOne); }, "Lqr", "B holds"));
}

TEST(LqrTest, WeightsAreChecked) {
  const MatrixXd A = DoubleIntegrator(), B = Vector2d(0, 1), Q = Matrix2d::Identity();
  const MatrixXd skew = (Matrix2d() << 1, 0.5, 0, 1).finished();
  const MatrixXd indefinite = Vector2d(1, -2).asDiagonal();
  EXPECT_TRUE(Refuses([&] { Lqr(A, B, skew, kOne); }, "Lqr", "Q is not symmetric"));
  EXPECT_TRUE(Refuses([&] { Lqr(A, B, indefinite, kOne); }, "Lqr", "eigenvalue -2"));
  EXPECT_TRUE(Refuses([&] { Lqr(A, B, Q, 0 * kOne); }, "Lqr", "R is not positive definite"));
  EXPECT_TRUE(Refuses([&] { Lqr(A, B, Q, kOne, Vector2d(2, 0)); }, "Lqr", "Q - N R^-1 N'"));
  EXPECT_TRUE(Refuses([&] { Kalman(A, B.transpose(), Q, -kOne); }, "Kalman", "R is not positive definite"));
}

TEST(LqrTest, ModesOutOfReachAreNamed) {
  const Vector2d first(1, 0);
  const Matrix2d unit = Matrix2d::Identity(), weighs_first = first.asDiagonal();
  const Matrix2d A = Vector2d(0.5, 2).asDiagonal();
  EXPECT_TRUE(Refuses([&] { Lqr(A, first, unit, kOne); }, "eigenvalue 2", "(A, B) is not stabilisable"));
  EXPECT_TRUE(Refuses([&] { DiscreteLqr(A, first, unit, kOne); }, "eigenvalue 2", "(A, B)"));
  EXPECT_TRUE(Refuses([&] { Lqr(A, Vector2d(1, 1), weighs_first, kOne); }, "eigenvalue 2", "(A, Q)"));
  EXPECT_TRUE(Refuses([&] { Kalman(A, first.transpose(), unit, kOne); }, "eigenvalue 2", "(A, C)"));
  EXPECT_TRUE(Refuses([&] { DiscreteKalman(A, Eigen::RowVector2d(1, 1), weighs_first, kOne); },
                      "eigenvalue 2", "(A, Q)"));
  // An oscillation without damping, and a drift.
  const Matrix2d turn = (Matrix2d() << 0, 3, -3, 0).finished();
  EXPECT_TRUE(Refuses([&] { Lqr(turn, 0 * first, unit, kOne); }, "eigenvalue 0 + 3 i", "(A, B)"));
  EXPECT_TRUE(Refuses([&] { Lqr(DoubleIntegrator(), first, unit, kOne); }, "eigenvalue 0", "(A, B)"));
}

TEST(LqrTest, WhatSixteenDigitsDoNotReachIsNoDesign) {
  // A chain of unstable modes with an input at its end.
  for (const int n : {10, 30}) {
    MatrixXd A = 2 * MatrixXd::Identity(n, n);
    A.diagonal(1).setConstant(1e-1);
    const MatrixXd B = MatrixXd::Identity(n, n).rightCols(1), Q = MatrixXd::Identity(n, n);
    for (const auto& design : {Lqr, DiscreteLqr})
      EXPECT_TRUE(Throws<ParameterError>([&] { design(A, B, Q, kOne, {}); }, "eigenvalue 2", "(A, B)")) << n;
  }
}

// p = q + a^2 p - a^2 p^2 b^2 / (r + b^2 p) is a quadratic equation for p.
TEST(DiscreteRiccati, ScalarInClosedForm) {
  const double a = 1.3, b = 0.4, q = 2, r = 0.7;
  const double half = (r * (1 - a * a) - q * b * b) / (2 * b * b);
  const double p = -half + std::sqrt(half * half + q * r / (b * b));
  const auto one = [](double value) { return Eigen::MatrixXd::Constant(1, 1, value); };
  EXPECT_THAT(SolveDiscreteRiccati(one(a), one(b), one(q), one(r)), IsNear(one(p), 1e-12));
}

TEST(DiscreteRiccati, SolvesTheEquationAndStabilises) {
  Eigen::Matrix4d A = Eigen::Matrix4d::Identity();
  A.topRightCorner<2, 2>() << 0.1, 0.02, 0, 0.1;
  A(2, 0) = 0.3;  // unstable
  Eigen::Matrix<double, 4, 2> B;
  B << 0.005, 0, 0, 0.005, 0.1, 0, 0.02, 0.1;
  const Eigen::Matrix4d Q = Eigen::Vector4d(10, 5, 1, 0).asDiagonal();
  const Eigen::Matrix2d R = Eigen::Vector2d(0.1, 0.2).asDiagonal();
  const Eigen::Matrix4d P = SolveDiscreteRiccati(A, B, Q, R);
  const Eigen::Matrix<double, 2, 4> K = test::Solve(R + B.transpose() * P * B, B.transpose() * P * A);
  const Eigen::Matrix4d residual = Q + A.transpose() * P * A - A.transpose() * P * B * K - P;
  EXPECT_LT(residual.norm(), 1e-10 * P.norm());
  EXPECT_LT(test::Eigenvalues(A - B * K).cwiseAbs().maxCoeff(), 1);
}

TEST(DiscreteRiccati, RefusesUnstabilisableSystems) {
  const Eigen::Matrix2d A = Eigen::Vector2d(1.2, 0.5).asDiagonal();
  EXPECT_TRUE(Throws<ParameterError>(
      [&] {
        SolveDiscreteRiccati(A, Eigen::Vector2d(0, 1), Eigen::Matrix2d::Identity(),
                             Eigen::MatrixXd::Identity(1, 1));
      },
      "stabilising"));
}

/// Turns by `angle` [rad] per unit of time.
Eigen::MatrixXd Turn(double angle) {
  Eigen::MatrixXd A(2, 2);
  A << 0, -angle, angle, 0;
  return A;
}

TEST(MatrixFunctions, EigenvaluesOfATurnAreImaginary) {
  const Eigen::VectorXcd values = Eigenvalues(Turn(0.3));
  EXPECT_NEAR(std::abs(values[0].imag()), 0.3, 1e-15);
  EXPECT_EQ(values[0], std::conj(values[1]));
}

TEST(MatrixFunctions, SymmetricEigenvaluesAscend) {
  Eigen::MatrixXd A(2, 2);
  A << 2, 1, 1, 2;
  EXPECT_THAT(SymmetricEigenvalues(A), IsNear(Eigen::Vector2d(1, 3), 1e-14));
}

TEST(MatrixFunctions, ExponentialOfATurnIsARotation) {
  Eigen::MatrixXd expected(2, 2);
  expected << std::cos(0.3), -std::sin(0.3), std::sin(0.3), std::cos(0.3);
  EXPECT_THAT(Exponential(Turn(0.3)), IsNear(expected, 1e-15));
}

TEST(MatrixFunctions, SolveLinearInvertsATurn) {
  EXPECT_THAT(SolveLinear(Turn(2), Eigen::Vector2d(1, 4)), IsNear(Eigen::Vector2d(2, -0.5), 1e-15));
}

// x + 2 y = 5: the least norm is along (1, 2), and a basic solution uses the larger coefficient only.
TEST(MatrixFunctions, LeastSquaresOfOneEquationForTwoUnknowns) {
  const Eigen::MatrixXd A = Eigen::RowVector2d(1, 2);
  const Eigen::VectorXd b = Eigen::VectorXd::Constant(1, 5);
  const LeastSquares least = SolveLeastSquares(A, b);
  EXPECT_EQ(least.rank, 1);
  EXPECT_THAT(least.x, IsNear(Eigen::Vector2d(1, 2), 1e-14));
  EXPECT_THAT(SolveLeastSquaresBasic(A, b), IsNear(Eigen::Vector2d(0, 2.5), 1e-14));
}

TEST(MatrixFunctions, RangeBasisSpansTheColumnsUpToTheThreshold) {
  Eigen::MatrixXd A(3, 2);
  A << 1, 1, 1, 1, 0, 1e-6;
  const RangeBasis exact = CalcRangeBasis(A), coarse = CalcRangeBasis(A, 1e-3);
  EXPECT_EQ(exact.rank, 2);
  EXPECT_EQ(coarse.rank, 1);
  const Eigen::MatrixXd range = exact.Q.leftCols(2);
  EXPECT_THAT(range * range.transpose() * A, IsNear(A, 1e-15));
}

}  // namespace tenon::lqr_test
