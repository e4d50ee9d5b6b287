#pragma once

#include <tenon/systems/block.h>
#include <tenon/systems/primitives/internal/elementwise.h>

namespace tenon {

template <internal::DoubleOrMatrix T = double>
struct SaturationParams {
  T lower = internal::Filled<T>(-std::numeric_limits<double>::infinity());  ///< [unit]
  T upper = internal::Filled<T>(std::numeric_limits<double>::infinity());   ///< [unit]
  std::string unit = "";                                                    ///< unit of input, output, limits
  std::string elements = "";                                                ///< names of the elements
  void Validate() const {
    Demand(internal::Everywhere([](double low, double high) { return low <= high; }, lower, upper),
           "lower must not exceed upper, in any element");
  }
};

/// A saturation, element by element:
///
///     y = min(max(u, lower), upper)
///
/// T is double or Vec<N>. The limits are Kinks: no integrator step spans one. NaN passes unchanged. Throws
/// ParameterError if a lower limit exceeds its upper limit or one is not a number.
template <internal::DoubleOrMatrix T = double>
class Saturation final : public LeafSystem<SaturationParams<T>> {
 public:
  using LeafSystem<SaturationParams<T>>::LeafSystem;
  using LeafSystem<SaturationParams<T>>::params;
  Parameter<T> lower{this, {"lower", params.unit, params.elements}, params.lower, "limit of y"};
  Parameter<T> upper{this, {"upper", params.unit, params.elements}, params.upper, "limit of y"};
  InputPort<T> u{this, {"u", params.unit, params.elements}};
  OutputPort<T> y{this,
                  {"y", params.unit, params.elements},
                  Uses(u, lower, upper),
                  [](const T& u_now, const T& low, const T& high) -> T {
                    const auto limit = [](double u_i, double least, double most) {
                      return std::clamp(u_i, least, most);
                    };
                    return internal::Elementwise(limit, u_now, low, high);
                  }};
  Kink kink{this, "kink", Uses(u, lower, upper), [](const T& u_now, const T& low, const T& high) {
              const auto piece = [](double u_i, double least, double most) {
                return u_i < least ? -1 : u_i > most ? 1 : 0;
              };
              return internal::PieceOf(piece, u_now, low, high);
            }};
};

}  // namespace tenon
