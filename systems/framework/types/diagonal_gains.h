#pragma once

#include <tenon/systems/framework/types/signal.h>

#include <initializer_list>

namespace tenon {

/// The diagonal of a matrix of gains or weights: one number per element, or one number that stands for all. A
/// file gives a list, or that number.
class DiagonalGains {
 public:
  DiagonalGains(double all = 0) : values_{all} {}  // NOLINT(google-explicit-constructor): shorthand
  DiagonalGains(std::initializer_list<double> each) : values_(each) {}

  double operator[](Eigen::Index i) const {
    return values_.size() == 1 ? values_[0] : values_[static_cast<std::size_t>(i)];
  }
  template <int N>
  Vec<N> As() const {
    return Vec<N>::NullaryExpr([this](Eigen::Index i) { return (*this)[i]; });
  }
  DiagonalGains& operator*=(double factor);
  /// The product with a vector, an expression of Eigen that refers to the gains.
  template <class V>
  friend auto operator*(const DiagonalGains& gains, const Eigen::MatrixBase<V>& v) {
    const auto gain = [&gains](Eigen::Index i) { return gains[i]; };
    return V::PlainObject::NullaryExpr(v.size(), gain).cwiseProduct(v.derived());
  }
  /// Throws ParameterError that begins with `name` unless there is one number, or one for each of `count`
  /// elements, which are called `elements` in the message.
  void CheckSize(const char* name, int count, const char* elements) const;

  double* data() { return values_.data(); }
  std::size_t size() const { return values_.size(); }
  void resize(std::size_t count) { values_.resize(count); }
  friend bool operator==(const DiagonalGains&, const DiagonalGains&) = default;

 private:
  std::vector<double> values_;
};

namespace internal {
template <>
struct ItemsOf<DiagonalGains> : ItemsOf<std::vector<double>> {};
}  // namespace internal

}  // namespace tenon
