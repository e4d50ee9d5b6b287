#include <tenon/systems/campaign/sampling.h>
#include <tenon/systems/framework/types/errors.h>

#include <boost/random/sobol.hpp>
#include <fmt/core.h>

#include <cmath>

namespace tenon {

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
    throw ParameterError(
        fmt::format("Sobol's sequence in {} dimensions exceeds the available direction numbers; draw some "
                    "keys by uniform",
                    dimensions));
  }
  return points;
}

}  // namespace tenon
