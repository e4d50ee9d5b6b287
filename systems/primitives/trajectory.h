#pragma once

#include <tenon/systems/framework/block/state.h>
#include <tenon/systems/primitives/internal/elementwise.h>

namespace tenon {

template <internal::DoubleOrMatrix T = double>
struct TrajectoryParams {
  std::vector<double> times = {};             ///< [s], increasing, at least two
  std::vector<T> values = {};                 ///< [unit], one for each time
  T start_velocity = internal::Filled<T>(0);  ///< at the first time [unit/s]
  T end_velocity = internal::Filled<T>(0);    ///< at the last time [unit/s]
  std::string unit = "";
  std::string elements = "";  ///< names of the elements of y and its derivatives
  void Validate() const {
    Demand(times.size() >= 2, "a trajectory needs two times or more");
    Demand(times.size() == values.size(), "a trajectory needs as many values as times: there are " +
                                              std::to_string(times.size()) + " times and " +
                                              std::to_string(values.size()) + " values");
    Demand(internal::IsFinite(times) && internal::IsFinite(values) && internal::IsFinite(start_velocity) &&
               internal::IsFinite(end_velocity),
           "times, values and velocities must be finite");
    Demand(std::adjacent_find(times.begin(), times.end(), std::greater_equal<>()) == times.end(),
           "times must increase from point to point");
  }
};

/// A trajectory and its derivatives at one time.
template <class T>
struct TrajectoryPoint {
  T y = internal::Filled<T>(0), dy = y, ddy = y;
  static FieldList Fields() {
    return {{"y", &TrajectoryPoint::y}, {"dy", &TrajectoryPoint::dy}, {"ddy", &TrajectoryPoint::ddy}};
  }
};

/// The cubic spline through given values at given times, twice continuously differentiable, with given
/// velocities at its ends (de Boor, "A Practical Guide to Splines", chapter IV). Outside of the given times,
/// y is the first or last value.
///
/// T is double or Vec<N>. The given times are NextJumps. Throws ParameterError if there are fewer than two
/// times, if they do not increase, if the numbers of times and values differ, or if one is not finite.
template <internal::DoubleOrMatrix T = double>
class Trajectory final : public LeafSystem<TrajectoryParams<T>> {
  using Point = TrajectoryPoint<T>;

 public:
  using LeafSystem<TrajectoryParams<T>>::LeafSystem;
  using LeafSystem<TrajectoryParams<T>>::params;

 private:
  const std::vector<T> velocities_ = SolveVelocities(params);
  Shared<Point> point_{this, "point", Uses(this->time), &Trajectory::Evaluate};

 public:
  OutputPort<T> y{this, {"y", params.unit, params.elements}, Uses(point_), [](const Point& p) -> const T& {
                    return p.y;
                  }};
  OutputPort<T> dy{this,
                   {"dy", internal::Per(params.unit, "s"), params.elements},
                   Uses(point_),
                   [](const Point& p) -> const T& { return p.dy; }};
  OutputPort<T> ddy{this,
                    {"ddy", internal::Per(params.unit, "s^2"), params.elements},
                    Uses(point_),
                    [](const Point& p) -> const T& { return p.ddy; }};
  NextJump next_bend{this, "next_bend", Uses(this->time),
                     [this](double t) { return NextOf(params.times, t); }};

 private:
  static std::vector<T> SolveVelocities(const TrajectoryParams<T>& p);
  Point Evaluate(double t) const;
};

/// Equal accelerations on both sides of every inner time give a tridiagonal system for the velocities.
template <internal::DoubleOrMatrix T>
std::vector<T> Trajectory<T>::SolveVelocities(const TrajectoryParams<T>& p) {
  const std::size_t last = p.times.size() - 1;
  std::vector<T> v(last + 1, p.start_velocity);
  v[last] = p.end_velocity;
  const auto inverse = [&](std::size_t i) { return 1 / (p.times[i + 1] - p.times[i]); };
  std::vector<double> upper(last + 1, 0.0);
  for (std::size_t i = 1; i < last; ++i) {
    const double before = inverse(i - 1), after = inverse(i);
    const double pivot = 2 * (before + after) - before * upper[i - 1];
    upper[i] = after / pivot;
    const T slope = 3 * before * before * (p.values[i] - p.values[i - 1]) +
                    3 * after * after * (p.values[i + 1] - p.values[i]);
    v[i] = (1 / pivot) * (slope - before * v[i - 1]);
  }
  for (std::size_t i = last; i-- > 1;) v[i] -= upper[i] * v[i + 1];
  return v;
}

template <internal::DoubleOrMatrix T>
TrajectoryPoint<T> Trajectory<T>::Evaluate(double t) const {
  const std::vector<double>& times = params.times;
  const T zero = internal::Filled<T>(0);
  if (t < times.front()) return {params.values.front(), zero, zero};
  if (t > times.back()) return {params.values.back(), zero, zero};
  const auto i = std::upper_bound(times.begin() + 1, times.end() - 1, t) - times.begin() - 1;
  const double h = times[i + 1] - times[i], s = t - times[i];
  const T slope = (1 / h) * (params.values[i + 1] - params.values[i]);
  const T &v0 = velocities_[i], &v1 = velocities_[i + 1];
  const T c2 = (1 / h) * (3 * slope - 2 * v0 - v1);
  const T c3 = (1 / (h * h)) * (v0 + v1 - 2 * slope);
  return {params.values[i] + s * (v0 + s * (c2 + s * c3)), v0 + s * (2 * c2 + 3 * s * c3),
          2 * c2 + 6 * s * c3};
}

}  // namespace tenon
