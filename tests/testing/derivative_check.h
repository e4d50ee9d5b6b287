#pragma once

#include <Eigen/Core>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

namespace tenon {

/// The Jacobian of f: vector -> vector at x by central differences; good to about 1e-9 of f's size for smooth
/// f.
template <class F, class X>
Eigen::MatrixXd NumericalJacobian(const F& f, const X& x) {
  const double scale = std::cbrt(std::numeric_limits<double>::epsilon());
  Eigen::MatrixXd jacobian;
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    typename X::PlainObject above = x, below = x;
    const double step = scale * std::max(1.0, std::abs(x[i]));
    above[i] += step;
    below[i] -= step;
    const Eigen::VectorXd difference = f(above) - f(below);
    if (i == 0) jacobian.resize(difference.size(), x.size());
    jacobian.col(i) = difference / (above[i] - below[i]);
  }
  return jacobian;
}

/// Checks that `jacobian` is the derivative of f: vector -> vector at x. The error of each element may be
/// `tolerance` * (1 + its absolute value). The failure message names the worst element.
///
///     EXPECT_TRUE(IsJacobian(J, [&](const Vec<3>& q) -> Vec<2> { return Foot(q); }, q, 1e-7));
template <class J, class F, class X>
::testing::AssertionResult IsJacobian(const Eigen::MatrixBase<J>& jacobian, const F& f, const X& x,
                                      double tolerance) {
  const Eigen::MatrixXd analytic = jacobian, numerical = NumericalJacobian(f, x);
  if (analytic.rows() != numerical.rows() || analytic.cols() != numerical.cols()) {
    return ::testing::AssertionFailure()
           << "the Jacobian is " << analytic.rows() << " x " << analytic.cols() << " but should be "
           << numerical.rows() << " x " << numerical.cols();
  }
  double worst = 0;
  Eigen::Index row = 0, col = 0;
  for (Eigen::Index c = 0; c < analytic.cols(); ++c) {
    for (Eigen::Index r = 0; r < analytic.rows(); ++r) {
      const double error = std::abs(analytic(r, c) - numerical(r, c)) / (1 + std::abs(numerical(r, c)));
      if (error <= worst) continue;
      worst = std::isnan(error) ? std::numeric_limits<double>::infinity() : error;
      row = r, col = c;
    }
  }
  if (worst <= tolerance) return ::testing::AssertionSuccess();
  std::ostringstream text;
  text.precision(9);
  text << "element (" << row << ", " << col << ") is " << analytic(row, col)
       << " but finite differences give " << numerical(row, col) << "; relative error " << worst
       << ", allowed " << tolerance;
  return ::testing::AssertionFailure() << text.str();
}

}  // namespace tenon
