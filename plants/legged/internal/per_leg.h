#pragma once

#include <Eigen/Core>

namespace tenon::internal {

/// A scalar for each of the four legs. All legs have equal structure, so code for one leg with this as
/// Eigen's scalar computes all legs in parallel. Every operation equals that of four doubles, bit for bit.
class PerLeg {
 public:
  PerLeg() = default;
  PerLeg(double x) : low_{x, x}, high_{x, x} {}  // equal for all legs
  PerLeg(double a, double b, double c, double d) : low_{a, b}, high_{c, d} {}
  /// Calls `f(leg)` for each leg.
  template <class F>
  static PerLeg Of(const F& f) {
    return {f(0), f(1), f(2), f(3)};
  }

  double operator[](int leg) const { return leg < 2 ? low_[leg] : high_[leg - 2]; }
  /// Sum over the legs, from the first to the last.
  double Sum() const { return low_[0] + low_[1] + high_[0] + high_[1]; }

  PerLeg& operator+=(const PerLeg& x) { return low_ += x.low_, high_ += x.high_, *this; }
  PerLeg& operator-=(const PerLeg& x) { return low_ -= x.low_, high_ -= x.high_, *this; }
  PerLeg& operator*=(const PerLeg& x) { return low_ *= x.low_, high_ *= x.high_, *this; }
  PerLeg& operator/=(const PerLeg& x) { return low_ /= x.low_, high_ /= x.high_, *this; }
  friend PerLeg operator+(PerLeg a, const PerLeg& b) { return a += b; }
  friend PerLeg operator-(PerLeg a, const PerLeg& b) { return a -= b; }
  friend PerLeg operator*(PerLeg a, const PerLeg& b) { return a *= b; }
  friend PerLeg operator/(PerLeg a, const PerLeg& b) { return a /= b; }
  friend PerLeg operator-(PerLeg a) { return a.low_ = -a.low_, a.high_ = -a.high_, a; }

 private:
  // Pairs are available on all processors of the architecture. Wider vectors would change the calling
  // convention between code compiled for different processors.
  typedef double Pair __attribute__((vector_size(16)));
  Pair low_, high_;
};

template <class T>
using Vector3 = Eigen::Matrix<T, 3, 1>;
template <class T>
using Matrix3 = Eigen::Matrix<T, 3, 3>;

}  // namespace tenon::internal

template <>
struct Eigen::NumTraits<tenon::internal::PerLeg> : Eigen::NumTraits<double> {
  using Real = tenon::internal::PerLeg;
  using NonInteger = tenon::internal::PerLeg;
  using Nested = tenon::internal::PerLeg;
  using Literal = tenon::internal::PerLeg;
};
