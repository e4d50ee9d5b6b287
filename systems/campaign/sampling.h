#pragma once

#include <tenon/systems/framework/block/random_stream.h>

#include <cstddef>
#include <vector>

namespace tenon {

// Points in [0, 1) that fill a space more evenly than random ones do.

/// One coordinate of a Latin hypercube of `count` points: in each of `count` equal intervals lies one of
/// them, at a random place, and they come in random order (McKay, Beckman, Conover, Technometrics 21, 1979).
/// Coordinates from independent streams make a hypercube of as many dimensions.
std::vector<double> LatinHypercube(std::size_t count, RandomStream& random);

/// The first `count` points of Sobol's sequence in `dimensions` dimensions, without the origin; by
/// [dimension][point]. The direction numbers are those of Boost.Random. Throws ParameterError for more
/// dimensions than these go.
std::vector<std::vector<double>> Sobol(std::size_t count, std::size_t dimensions);

}  // namespace tenon
