#pragma once

#include <tenon/systems/framework/types/signal.h>

#include <algorithm>
#include <initializer_list>

namespace tenon::internal {

/// Value types of most primitives: a double, a Vec<N>, or another matrix of fixed size.
template <class T>
concept DoubleOrMatrix = std::same_as<T, double> ||
    (InlineMatrix<T>&& std::same_as<typename T::Scalar, double>);

/// A vector of doubles whose size is known only at run time, with any alignment.
template <class T>
concept VectorOfRunTimeSize = std::derived_from<T, Eigen::PlainObjectBase<T>> &&
                                  T::RowsAtCompileTime == Eigen::Dynamic&& T::ColsAtCompileTime == 1 &&
                              std::same_as<typename T::Scalar, double>;

/// Value types of noise: those of most primitives, and structs that describe themselves.
template <class T>
concept DoublesInside = DoubleOrMatrix<T> || HasFields<T>;

/// A T in which every number is `number`.
template <DoubleOrMatrix T>
T Filled(double number) {
  if constexpr (std::same_as<T, double>) {
    return number;
  } else {
    return T::Constant(number);
  }
}

/// A T in which every number is `number`, or a struct in which every number is zero.
template <DoublesInside T>
T FilledOrZero([[maybe_unused]] double number) {
  if constexpr (DoubleOrMatrix<T>) {
    return Filled<T>(number);
  } else {
    return Zeroed<T>();
  }
}

/// Applies `function` to the elements of the values, one by one and in order.
template <class F, DoubleOrMatrix T, std::same_as<T>... More>
T Elementwise(F function, const T& first, const More&... more) {
  if constexpr (std::same_as<T, double>) {
    return function(first, more...);
  } else {
    T result = first;
    for (Eigen::Index i = 0; i < first.size(); ++i)
      result.data()[i] = function(first.data()[i], more.data()[i]...);
    return result;
  }
}

/// True if `condition` holds for all elements of the values.
template <class F, DoubleOrMatrix T, std::same_as<T>... More>
bool Everywhere(F condition, const T& first, const More&... more) {
  bool all = true;
  Elementwise(
      [&](double a, auto... b) {
        all &= condition(a, b...);
        return a;
      },
      first, more...);
  return all;
}

/// An index, for a Kink, of the pieces on which the elements of the values are; it changes if one of them
/// does.
template <class F, DoubleOrMatrix T, std::same_as<T>... More>
std::int64_t PieceOf(F piece, const T& first, const More&... more) {
  if constexpr (std::same_as<T, double>) {
    return static_cast<std::int64_t>(piece(first, more...));
  } else {
    std::uint64_t combined = 0;
    for (Eigen::Index i = 0; i < first.size(); ++i) {
      const auto each = static_cast<std::int64_t>(piece(first.data()[i], more.data()[i]...));
      // An odd factor keeps the difference that any one element makes in the low bits.
      combined = combined * 1000003 + static_cast<std::uint64_t>(each);
    }
    return static_cast<std::int64_t>(combined & ((std::uint64_t{1} << 53) - 1));  // a double holds 53 bits
  }
}

inline double* DoublesAt(void* value, std::size_t offset) {
  return reinterpret_cast<double*>(static_cast<std::byte*>(value) + offset);
}
inline const double* DoublesAt(const void* value, std::size_t offset) {
  return reinterpret_cast<const double*>(static_cast<const std::byte*>(value) + offset);
}

/// Calls `visit(double&, …)` for each double of the values, in order. Their type must have a fixed size.
template <class F, class T, class... More>
void ForEachDouble(F visit, T& first, More&... more) {
  for (const ScalarRun& run : TypeInfoOf<std::remove_const_t<T>>().runs) {
    if (run.kind != ScalarKind::kDouble) continue;
    for (std::size_t i = 0; i < run.count; ++i)
      visit(DoublesAt(&first, run.offset)[i], DoublesAt(&more, run.offset)[i]...);
  }
}

/// The derivative of a sampled signal, with a first-order low-pass filter, by backward differences:
///
///     d[n] = (T d[n - 1] + u[n] - u[n - 1]) / (T + h),   d[0] = 0
///
/// Stable for every T >= 0; T = 0 gives the plain difference (Åström and Hägglund, "PID Controllers: Theory,
/// Design, and Tuning", ISA 1995, chapter 3).
template <DoubleOrMatrix T>
struct FilteredDifference {
  T u = Filled<T>(0), d = Filled<T>(0);
  bool started = false;

  FilteredDifference Next(const T& next_u, double time_constant, double period) const {
    if (!started) return {next_u, d, true};
    return {next_u, (1 / (time_constant + period)) * (time_constant * d + (next_u - u)), true};
  }
  static FieldList Fields() {
    return {{"u", &FilteredDifference::u},
            {"d", &FilteredDifference::d},
            {"started", &FilteredDifference::started}};
  }
};

/// Divides each of the comma-separated units by a unit of time: "m, rad" per "s" is "m/s, rad/s".
inline std::string Per(const std::string& units, const std::string& time) {
  std::string quotients;
  for (const char c : units + ",") {
    if (c == ',' && !quotients.empty()) quotients += "/" + time;
    quotients += c;
  }
  quotients.pop_back();
  return quotients;
}

/// y = M v, or y += M v with `add`. Throws RunError that names M and v if their sizes do not match.
template <class Matrix, class V, class Y>
void Multiply(const char* m_name, const Matrix& m, const char* v_name, const V& v, Y* y, bool add = false) {
  if (m.cols() != v.size()) {
    throw RunError(std::string(v_name) + " has " + std::to_string(v.size()) + " elements, but " + m_name +
                   " has " + std::to_string(m.cols()) + " columns: make them equal");
  }
  if (add) {
    y->noalias() += m * v;
  } else {
    y->noalias() = m * v;
  }
}

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
