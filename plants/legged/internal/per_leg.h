#pragma once

#include <Eigen/Core>

namespace tenon::internal {

/// A number of each of the four legs. All legs have the same joints and bodies one after the other, so that
/// what is written once for a leg, with this as Eigen's scalar, is computed for all of them at a time. Every
/// operation is that of four doubles, bit for bit.
class PerLeg {
 public:
  PerLeg() = default;
  PerLeg(double x) : low_{x, x}, high_{x, x} {}  // of all legs the same
  PerLeg(double a, double b, double c, double d) : low_{a, b}, high_{c, d} {}
  /// `f(leg)` of each leg.
  template <class F>
  static PerLeg Of(const F& f) {
    return {f(0), f(1), f(2), f(3)};
  }

  double operator[](int leg) const { return leg < 2 ? low_[leg] : high_[leg - 2]; }
  /// Over the legs, from the first to the last.
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
  // Two of what every processor of the kind has, and no wider vectors: these would be passed in other ways by
  // code for other processors.
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
