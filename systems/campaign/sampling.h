#pragma once

#include <cstddef>
#include <vector>

namespace tenon {

/// The first `count` points of Sobol's sequence in `dimensions` dimensions, without the origin, indexed by
/// [dimension][point]: they cover the space [0, 1) more evenly than random points. The direction numbers are
/// those of Boost.Random. Throws ParameterError if `dimensions` exceeds their number.
std::vector<std::vector<double>> Sobol(std::size_t count, std::size_t dimensions);

}  // namespace tenon
