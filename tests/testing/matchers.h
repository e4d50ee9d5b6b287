#pragma once

#include <Eigen/Core>
#include <gmock/gmock.h>

#include <cmath>
#include <ostream>

namespace tenon {

/// The matcher behind IsNear.
class NearMatrix {
 public:
  using is_gtest_matcher = void;

  template <class Derived>
  NearMatrix(const Eigen::MatrixBase<Derived>& expected, double tolerance)
      : expected_(expected), tolerance_(tolerance) {}

  template <class Derived>
  bool MatchAndExplain(const Eigen::MatrixBase<Derived>& actual, std::ostream* explanation) const {
    return Compare(actual, explanation);
  }
  void DescribeTo(std::ostream* out) const { Describe("is", out); }
  void DescribeNegationTo(std::ostream* out) const { Describe("is not", out); }

 private:
  bool Compare(const Eigen::MatrixXd& actual, std::ostream* explanation) const {
    if (actual.rows() != expected_.rows() || actual.cols() != expected_.cols()) {
      if (explanation != nullptr) {
        *explanation << "which is " << actual.rows() << " x " << actual.cols() << " instead of "
                     << expected_.rows() << " x " << expected_.cols();
      }
      return false;
    }
    int wrong = 0;
    for (Eigen::Index c = 0; c < actual.cols(); ++c) {
      for (Eigen::Index r = 0; r < actual.rows(); ++r) {
        const double is = actual(r, c), should_be = expected_(r, c);
        if (is == should_be || std::abs(is - should_be) <= tolerance_) continue;
        if (++wrong > kShown || explanation == nullptr) continue;
        *explanation << (wrong == 1 ? "whose element " : "; element ") << '(' << r << ", " << c << ") is "
                     << is << " instead of " << should_be << ", off by " << is - should_be;
      }
    }
    if (wrong > kShown && explanation != nullptr) *explanation << "; and " << wrong - kShown << " more";
    return wrong == 0;
  }
  void Describe(const char* verb, std::ostream* out) const {
    static const Eigen::IOFormat kOneLine(Eigen::StreamPrecision, Eigen::DontAlignCols, ", ", "; ", "", "",
                                          "[", "]");
    *out << verb << " within " << tolerance_ << " of " << expected_.format(kOneLine);
  }

  static constexpr int kShown = 6;
  Eigen::MatrixXd expected_;
  double tolerance_;
};

/// Matches a matrix of the same shape all of whose elements differ by at most `tolerance`; says which do not.
/// NaN is near nothing.
///
///     EXPECT_THAT(rig[rig.system().y], IsNear(Vec<2>(1, 0), 1e-9));
template <class Derived>
NearMatrix IsNear(const Eigen::MatrixBase<Derived>& expected, double tolerance) {
  return {expected, tolerance};
}

/// Matches a text that contains all `parts`.
///
///     EXPECT_THAT(error, HasSubstrs("'cart'", "mass_kg"));
template <class... Parts>
auto HasSubstrs(const Parts&... parts) {
  return ::testing::AllOf(::testing::HasSubstr(parts)...);
}

}  // namespace tenon
