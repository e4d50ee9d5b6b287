#include <tenon/systems/analysis/lqr.h>
#include <tenon/systems/framework/block/random_stream.h>
#include <tenon/systems/framework/types/errors.h>
#include <tenon/tests/testing/dense_algebra.h>
#include <tenon/tests/testing/expect_throws.h>
#include <tenon/tests/testing/matchers.h>

#include <Eigen/Core>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace tenon::lqr_test {
namespace {

using Eigen::Matrix2d;
using Eigen::MatrixXd;
using Eigen::Vector2d;

const MatrixXd kOne = MatrixXd::Ones(1, 1);

MatrixXd Random(Eigen::Index rows, Eigen::Index cols, RandomStream& random) {
  return MatrixXd::NullaryExpr(rows, cols, [&] { return random.Uniform(-1, 1); });
}

/// A problem without structure, most of its modes unstable; quantities of sizes from 10^-span to 10^span.
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
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
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
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
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

TEST(LqrTest, IsWhereTheRiccatiDifferentialEquationEnds) {
  // -dS/dt = A'S + S A - (S B + N) R⁻¹ (B'S + N') + Q, backwards from S = 0.
  Problem p(4, 2, 5, 0);
  p.R += Matrix2d::Identity();  // forces that cost little would make it stiff
  const MatrixXd inverse = test::Inverse(p.R);
  const auto rate = [&](const MatrixXd& S) -> MatrixXd {
    const MatrixXd cross = S * p.B + p.N;
    return p.A.transpose() * S + S * p.A - cross * inverse * cross.transpose() + p.Q;
  };
  MatrixXd S = MatrixXd::Zero(4, 4);
  constexpr double h = 1e-2;
  for (int i = 0; i < 5000; ++i) {
    const MatrixXd k1 = rate(S), k2 = rate(S + h / 2 * k1), k3 = rate(S + h / 2 * k2), k4 = rate(S + h * k3);
    S += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
    S = 0.5 * (S + S.transpose()).eval();  // what is skew would grow
  }
  EXPECT_THAT(Lqr(p.A, p.B, p.Q, p.R, p.N).S, IsNear(S, 1e-8 * S.norm()));
}

TEST(LqrTest, IsWhereTheRiccatiDifferenceEquationEnds) {
  const Problem p(4, 2, 6, 0);
  MatrixXd S = MatrixXd::Zero(4, 4);
  for (int i = 0; i < 2000; ++i) {
    const MatrixXd cross = p.A.transpose() * S * p.B + p.N;
    S = p.A.transpose() * S * p.A - cross * test::Solve(p.R + p.B.transpose() * S * p.B, cross.transpose()) +
        p.Q;
    S = 0.5 * (S + S.transpose()).eval();
  }
  EXPECT_THAT(DiscreteLqr(p.A, p.B, p.Q, p.R, p.N).S, IsNear(S, 1e-9 * S.norm()));
}

TEST(LqrTest, SizesOfAllKinds) {
  // Springs from soft to stiff, a force each in a unit of its own.
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
    // Each by itself: s12 = (sqrt(w⁴ + g) - w²) / g with g = b²/r, and s22 = sqrt((2 s12 + 1) / g).
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

// ---- Filters ----

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

// ---- What is refused ----

TEST(LqrTest, SizesAreChecked) {
  const MatrixXd A = DoubleIntegrator(), B = Vector2d(0, 1), Q = Matrix2d::Identity();
  const auto refuses = [](const auto& call, const char* text) { return Throws<ParameterError>(call, text); };
  EXPECT_TRUE(refuses([&] { Lqr(B, B, Q, kOne); }, "Lqr: A is 2 x 1, but should be 2 x 2"));
  EXPECT_TRUE(refuses([&] { Lqr({}, B, Q, kOne); }, "Lqr: A is 0 x 0, but should be 1 x 1"));
  EXPECT_TRUE(refuses([&] { Lqr(A, kOne, Q, kOne); }, "Lqr: B is 1 x 1, but should be 2 x 1"));
  EXPECT_TRUE(refuses([&] { Lqr(A, B, kOne, kOne); }, "Lqr: Q is 1 x 1, but should be 2 x 2"));
  EXPECT_TRUE(refuses([&] { DiscreteLqr(A, B, Q, Q); }, "DiscreteLqr: R is 2 x 2, but should be 1 x 1"));
  EXPECT_TRUE(refuses([&] { Lqr(A, B, Q, kOne, kOne); }, "Lqr: N is 1 x 1, but should be 2 x 1"));
  EXPECT_TRUE(refuses([&] { Kalman(A, B, Q, kOne); }, "Kalman: C is 2 x 1, but should be 2 x 2"));
  EXPECT_TRUE(refuses([&] { DiscreteKalman(A, B.transpose(), Q, Q); },
                      "DiscreteKalman: R is 2 x 2, but should be 1 x 1"));
  EXPECT_TRUE(refuses([&] { Lqr(A, B * NAN, Q, kOne); }, "Lqr: B holds numbers that are not finite"));
}

TEST(LqrTest, WeightsAreChecked) {
  const MatrixXd A = DoubleIntegrator(), B = Vector2d(0, 1), Q = Matrix2d::Identity();
  const auto refuses = [](const auto& call, const char* text) { return Throws<ParameterError>(call, text); };
  const MatrixXd skew = (Matrix2d() << 1, 0.5, 0, 1).finished();
  EXPECT_TRUE(
      refuses([&] { Lqr(A, B, skew, kOne); }, "Lqr: Q is not symmetric: two of its elements differ by 0.5"));
  EXPECT_TRUE(refuses([&] { Lqr(A, B, Vector2d(1, -2).asDiagonal().toDenseMatrix(), kOne); },
                      "Lqr: Q is not positive semidefinite: it has the eigenvalue -2"));
  EXPECT_TRUE(
      refuses([&] { Lqr(A, B, Q, 0 * kOne); }, "Lqr: R is not positive definite: it has the eigenvalue 0"));
  EXPECT_TRUE(refuses([&] { Lqr(A, B, Q, kOne, Vector2d(2, 0)); },
                      "Lqr: Q - N R^-1 N' is not positive semidefinite: it has the eigenvalue -3"));
  EXPECT_TRUE(refuses([&] { Kalman(A, B.transpose(), Q, -kOne); },
                      "Kalman: R is not positive definite: it has the eigenvalue -1"));
}

TEST(LqrTest, ModesOutOfReachAreNamed) {
  const auto refuses = [](const auto& call, const char* text) { return Throws<ParameterError>(call, text); };
  const Vector2d first(1, 0);
  const Matrix2d unit = Matrix2d::Identity(), weighs_first = first.asDiagonal();
  const Matrix2d A = Vector2d(0.5, 2).asDiagonal();
  EXPECT_TRUE(
      refuses([&] { Lqr(A, first, unit, kOne); },
              "Lqr: the mode with eigenvalue 2 does not decay and is not controllable by B: (A, B) is not "
              "stabilisable"));
  EXPECT_TRUE(refuses([&] { DiscreteLqr(A, first, unit, kOne); }, "eigenvalue 2 does not decay and "));
  EXPECT_TRUE(refuses([&] { Lqr(A, Vector2d(1, 1), weighs_first, kOne); },
                      "eigenvalue 2 does not decay and has no weight in Q: (A, Q) is not detectable"));
  EXPECT_TRUE(refuses([&] { Kalman(A, first.transpose(), unit, kOne); },
                      "eigenvalue 2 does not decay and is not observable by C: (A, C) is not detectable"));
  EXPECT_TRUE(refuses([&] { DiscreteKalman(A, Eigen::RowVector2d(1, 1), weighs_first, kOne); },
                      "eigenvalue 2 does not decay and is not excited by Q: (A, Q) is not stabilisable"));
  // A drift, and an oscillation that nobody damps.
  const Matrix2d turn = (Matrix2d() << 0, 3, -3, 0).finished();
  EXPECT_TRUE(refuses([&] { Lqr(turn, 0 * first, unit, kOne); }, "eigenvalue 0 + 3 i does not decay"));
  EXPECT_TRUE(refuses([&] { Lqr(DoubleIntegrator(), first, unit, kOne); },
                      "eigenvalue 0 does not decay and is not controllable by B"));
}

TEST(LqrTest, WhatSixteenDigitsDoNotReachIsNoDesign) {
  // A chain of unstable modes that is pushed at its end.
  for (const int n : {10, 30}) {
    MatrixXd A = 2 * MatrixXd::Identity(n, n);
    A.diagonal(1).setConstant(1e-1);
    const MatrixXd B = MatrixXd::Identity(n, n).rightCols(1), Q = MatrixXd::Identity(n, n);
    for (const auto& design : {Lqr, DiscreteLqr}) {
      EXPECT_TRUE(Throws<ParameterError>([&] { design(A, B, Q, kOne, {}); },
                                         "eigenvalue 2 does not decay and is not controllable by B"))
          << n;
    }
  }
}

}  // namespace
}  // namespace tenon::lqr_test
