#pragma once

#include <tenon/systems/framework/block/random_stream.h>

#include <cstddef>
#include <vector>

namespace tenon {

// Points in [0, 1) that cover a space more evenly than random points.

/// One coordinate of a Latin hypercube of `count` points: each of `count` equal intervals contains one point
/// at a random place; the points have random order (McKay, Beckman, Conover, Technometrics 21, 1979).
/// Coordinates from independent streams form a hypercube of several dimensions.
std::vector<double> LatinHypercube(std::size_t count, RandomStream& random);

/// The first `count` points of Sobol's sequence in `dimensions` dimensions, without the origin, indexed by
/// [dimension][point]. The direction numbers are those of Boost.Random. Throws ParameterError if `dimensions`
/// exceeds their number.
std::vector<std::vector<double>> Sobol(std::size_t count, std::size_t dimensions);

}  // namespace tenon
