#pragma once

#include <tenon/systems/block.h>
#include <tenon/systems/primitives/internal/elementwise.h>

namespace tenon {

struct GainParams {
  double gain = 1;            ///< [unit of y / unit of u]
  std::string u_unit = "";    ///< unit of the input
  std::string y_unit = "";    ///< unit of the output
  std::string elements = "";  ///< names of the elements of u and y
};

/// A multiplication by a scalar:
///
///     y = gain u
///
/// T is double or Vec<N>. Throws ParameterError if the gain is not finite.
template <internal::DoubleOrMatrix T = double>
class Gain final : public LeafSystem<GainParams> {
 public:
  using LeafSystem::LeafSystem;
  Parameter<double> gain{this, "gain", params.gain, "factor in unit of y / unit of u", Range().Finite()};
  InputPort<T> u{this, {"u", params.u_unit, params.elements}};
  OutputPort<T> y{
      this, {"y", params.y_unit, params.elements}, Uses(gain, u), [](double gain_now, const T& u_now) -> T {
        return gain_now * u_now;
      }};
};

template <int Rows = Eigen::Dynamic, int Cols = Rows>
struct MatrixGainParams {
  static constexpr bool kDynamic = Rows == Eigen::Dynamic || Cols == Eigen::Dynamic;
  static constexpr int kOrder = Rows == 1 && Cols != 1 ? Eigen::RowMajor : Eigen::ColMajor;
  /// Eigen::MatrixXd, or like Vec<N> a matrix of fixed size that is never over-aligned.
  using Matrix = Eigen::Matrix<double, Rows, Cols, kOrder | (kDynamic ? 0 : Eigen::DontAlign)>;
  Matrix gain = internal::Zeroed<Matrix>();  ///< [y_unit / u_unit]
  std::string u_unit = "";                   ///< unit of the input
  std::string y_unit = "";                   ///< unit of the output
  std::string u_elements = "";               ///< names of the input's elements
  std::string y_elements = "";               ///< names of the output's elements
  void Validate() const {
    Demand(gain.size() > 0, "gain must not be empty: give a matrix of as many columns as u has elements");
  }
};

/// A multiplication by a matrix:
///
///     y = gain u
///
/// The size of MatrixGain<> is that of its matrix, known at run time, and its ports are Eigen::VectorXd.
/// Throws ParameterError if the matrix is empty or not finite, and RunError if the size of u differs from the
/// number of columns.
template <int Rows = Eigen::Dynamic, int Cols = Rows>
class MatrixGain final : public LeafSystem<MatrixGainParams<Rows, Cols>> {
  using Matrix = typename MatrixGainParams<Rows, Cols>::Matrix;

 public:
  using LeafSystem<MatrixGainParams<Rows, Cols>>::LeafSystem;
  using LeafSystem<MatrixGainParams<Rows, Cols>>::params;
  Parameter<Matrix> gain{this, "gain", params.gain, "matrix in unit of y / unit of u", Range().Finite()};
  InputPort<Vec<Cols>> u{this, {"u", params.u_unit, params.u_elements}};
  OutputPort<Vec<Rows>> y{this,
                          {"y", params.y_unit, params.y_elements},
                          Vec<Rows>::Zero(params.gain.rows()),
                          Uses(gain, u),
                          [](const Matrix& gain_now, const Vec<Cols>& u_now, Vec<Rows>* y_out) {
                            internal::Multiply("gain", gain_now, "u", u_now, y_out);
                          }};
};

}  // namespace tenon
