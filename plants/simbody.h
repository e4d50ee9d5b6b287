#pragma once

/// The one door to Simbody. Include this and never <Simbody.h>, and include it from .cc files alone: then
/// only the translation units that build a model pay for Simbody's headers (2 s each) and for what follows.
///
/// Simbody 3.7 as Debian packages it needs three cures:
///  - Its index types convert to int and compare with every integer type by members that are not symmetric.
///    C++20 also tries each comparison reversed, which makes `a == b` of two indices ambiguous. The operator
///    below is an exact match for both orders, for those types alone.
///  - The packaged libraries are compiled without NDEBUG, and a struct of StateImpl.h has members that exist
///    only without it. A translation unit compiled with -DNDEBUG, as CMake's Release does, lays that struct
///    out differently from the library and crashes when it realizes a topology. So such files are compiled
///    with -UNDEBUG after the build type's flags; the #error says so before the crash does.
///  - clang refuses a template in the header of the multibody graph maker, which nothing here uses.
///
/// Never `using namespace SimTK`: its Vec3, Real or Matrix would stand beside Eigen's and Tenon's.

#ifdef NDEBUG
#error "Simbody's packaged libraries are built without NDEBUG: compile this file with -UNDEBUG"
#endif

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
