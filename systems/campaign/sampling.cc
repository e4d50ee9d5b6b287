#include <tenon/systems/campaign/sampling.h>
#include <tenon/systems/framework/types/errors.h>

#include <boost/random/sobol.hpp>
#include <fmt/core.h>

#include <cmath>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace tenon {

std::vector<double> LatinHypercube(std::size_t count, RandomStream& random) {
  std::vector<std::size_t> interval(count);
  std::iota(interval.begin(), interval.end(), std::size_t{0});
  for (std::size_t left = count; left > 1; --left) {  // Fisher and Yates
    const auto other = static_cast<std::size_t>(random.Uniform() * static_cast<double>(left));
    std::swap(interval[left - 1], interval[other]);
  }
  std::vector<double> points(count);
  for (std::size_t k = 0; k < count; ++k)
    points[k] = (static_cast<double>(interval[k]) + random.Uniform()) / static_cast<double>(count);
  return points;
}

std::vector<std::vector<double>> Sobol(std::size_t count, std::size_t dimensions) {
  if (dimensions == 0) return {};
  std::vector<std::vector<double>> points(dimensions, std::vector<double>(count));
  if (count == 0) return points;
  using Engine = boost::random::sobol_engine<std::uint_least64_t, 64u>;
  try {
    Engine engine(dimensions);
    for (std::size_t k = 0; k < count; ++k)
      for (auto& coordinate : points)
        coordinate[k] = static_cast<double>(engine() >> 11) * std::ldexp(1.0, -53);
  } catch (const std::invalid_argument&) {
    throw ParameterError(fmt::format(
        "Sobol's sequence in {} dimensions exceeds the available direction numbers; draw some keys by "
        "latin_hypercube",
        dimensions));
  }
  return points;
}

}  // namespace tenon
