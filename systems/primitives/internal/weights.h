#pragma once

#include <tenon/systems/framework/types/internal/type_info.h>

#include <algorithm>
#include <initializer_list>

namespace tenon::internal {

/// Like std::vector<double>, but stores up to two numbers in the object itself, so that calculations in every
/// step follow no pointer.
class Weights {
 public:
  Weights() = default;
  Weights(std::initializer_list<double> weights) : Weights(std::vector<double>(weights)) {}
  Weights(std::vector<double> weights) : size_(weights.size()) {
    if (size_ > few_.size()) {
      many_ = std::move(weights);
    } else {
      std::copy(weights.begin(), weights.end(), few_.begin());
    }
  }
  bool empty() const { return size_ == 0; }
  std::size_t size() const { return size_; }
  const double* data() const { return size_ > few_.size() ? many_.data() : few_.data(); }
  double* data() { return size_ > few_.size() ? many_.data() : few_.data(); }
  const double* begin() const { return data(); }
  const double* end() const { return data() + size_; }
  double operator[](std::size_t i) const { return data()[i]; }
  /// Resizes; new elements are zero.
  void resize(std::size_t size) {
    std::vector<double> weights(begin(), end());
    weights.resize(size);
    *this = Weights(std::move(weights));
  }
  friend bool operator==(const Weights& a, const Weights& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end());
  }

 private:
  std::size_t size_ = 0;
  std::array<double, 2> few_ = {};
  std::vector<double> many_ = {};  ///< all elements, if there are more than two
};

template <>
struct ItemsOf<Weights> : ItemsOf<std::vector<double>> {};

}  // namespace tenon::internal
