#pragma once

#include <tenon/systems/framework/block/state.h>
#include <tenon/systems/primitives/internal/elementwise.h>

namespace tenon {

template <internal::DoubleOrMatrix T = double>
struct TableParams {
  std::vector<double> u = {};  ///< [u_unit], increasing, at least two
  std::vector<T> y = {};       ///< [y_unit], one for each u
  std::string u_unit = "";
  std::string y_unit = "";
  std::string elements = "";  ///< names of the elements of y
  void Validate() const {
    Demand(u.size() >= 2, "a table needs two points or more");
    Demand(u.size() == y.size(), "a table needs as many values y as u: there are " +
                                     std::to_string(u.size()) + " u and " + std::to_string(y.size()) + " y");
    Demand(internal::IsFinite(u) && internal::IsFinite(y), "u and y must be finite");
    Demand(std::adjacent_find(u.begin(), u.end(), std::greater_equal<>()) == u.end(),
           "u must increase from point to point");
  }
};

/// A function given by points (u_k, y_k), linear between the points and constant outside of them.
///
/// T is double or Vec<N>. The points are Kinks. y is NaN if u is. Throws ParameterError if there are fewer
/// than two points, if u does not increase, if the numbers of u and y differ, or if a value is not finite.
template <internal::DoubleOrMatrix T = double>
class Table final : public LeafSystem<TableParams<T>> {
 public:
  using LeafSystem<TableParams<T>>::LeafSystem;
  using LeafSystem<TableParams<T>>::params;
  InputPort<double> u{this, {"u", params.u_unit}};
  OutputPort<T> y{this, {"y", params.y_unit, params.elements}, Uses(u), [this](double u_now) -> T {
                    const auto& points = params.u;
                    const double inside = std::clamp(u_now, points.front(), points.back());
                    const auto next = std::upper_bound(points.begin() + 1, points.end() - 1, inside);
                    const auto i = next - points.begin();
                    const double w = (inside - points[i - 1]) / (points[i] - points[i - 1]);
                    return (1 - w) * params.y[i - 1] + w * params.y[i];
                  }};
  Kink kink{
      this, "kink", Uses(u), [this](double u_now) {
        return std::int64_t{std::upper_bound(params.u.begin(), params.u.end(), u_now) - params.u.begin()};
      }};
};

}  // namespace tenon
