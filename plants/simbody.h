#pragma once

/// Includes Simbody. Include this header instead of <Simbody.h>, and only in .cc files, so that only
/// translation units that build a model have to compile Simbody's headers (2 s each).
///
/// It also works around three problems of Simbody 3.7 as packaged by Debian:
///  - Its index types convert to int and have members that compare them with every integer type. In C++20,
///    which also tries each comparison with reversed operands, `a == b` of two indices is therefore
///    ambiguous. The operator below is an exact match for these types in both orders.
///  - A struct in StateImpl.h has members that exist only without NDEBUG, and the packaged libraries are
///    compiled without it. A translation unit compiled with -DNDEBUG, as in CMake's Release build, therefore
///    has a different layout of that struct and crashes when it realizes a topology. The #error requires
///    -UNDEBUG after the build type's flags.
///  - Clang rejects a template in the header of the multibody graph maker, which Tenon does not use.
///
/// Do not write `using namespace SimTK`: its Vec3, Real and Matrix are easily confused with Eigen's and
/// Tenon's.

#ifdef NDEBUG
#error "Simbody's packaged libraries are built without NDEBUG: compile this file with -UNDEBUG"
#endif

#include <tenon/systems/framework/types/internal/held_exceptions.h>

#include <concepts>

namespace SimTK {

template <class Index>
concept UniqueIndex = requires(Index& index, const Index& constant) {
  index.invalidate();
  { constant.isValidExtended() } -> std::same_as<bool>;
  { constant.operator int() } -> std::same_as<int>;
  Index(0);
};

template <UniqueIndex Index>
bool operator==(const Index& a, const Index& b) {
  return a.operator int() == b.operator int();
}

}  // namespace SimTK

#ifdef __clang__
#define SimTK_SIMMATH_MULTIBODY_GRAPH_MAKER_H_
#endif

#include <Simbody.h>

namespace tenon {

/// Realizes the topology of a system. Simbody computes with the infinite mass of the ground there, which
/// would trap in a program that calls feenableexcept.
inline void RealizeTopology(SimTK::MultibodySystem& system) {
  const internal::HeldExceptions held;
  system.realizeTopology();
}

}  // namespace tenon
