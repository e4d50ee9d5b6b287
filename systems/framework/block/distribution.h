#pragma once

#include <tenon/systems/framework/block/random_stream.h>

#include <optional>

namespace tenon {

/// A probability distribution of a number, given by its name in files and two parameters:
///
///     uniform    lower bound, upper bound
///     normal     mean, standard deviation
///     lognormal  mean and standard deviation of the logarithm
class Distribution {
 public:
  /// Returns the distribution with this name, or `nullopt` if there is none.
  static std::optional<Distribution> Named(std::string_view name, const std::array<double, 2>& parameters);

  /// Throws ParameterError if the bounds are in the wrong order or the standard deviation is negative.
  void Validate() const;
  double Draw(RandomStream& random) const;

 private:
  enum class Kind { kUniform, kNormal, kLognormal };
  Distribution(Kind kind, std::string_view name, const std::array<double, 2>& parameters)
      : kind_(kind), name_(name), parameters_(parameters) {}

  Kind kind_;
  std::string name_;
  std::array<double, 2> parameters_;
};

}  // namespace tenon
