#pragma once

// The headers that tests of blocks share.

#include <tenon/systems/framework/block/random_stream.h>
#include <tenon/systems/framework/diagram/diagram_builder.h>
#include <tenon/systems/framework/types/errors.h>
#include <tenon/tests/testing/allocation_guard.h>
#include <tenon/tests/testing/expect_throws.h>
#include <tenon/tests/testing/matchers.h>
#include <tenon/tests/testing/test_rig.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tenon {

namespace test {

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();
inline constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

}  // namespace test

/// Returns whether the constructor of a Block throws a ParameterError that names all the `keys`.
///
///     EXPECT_TRUE(Refuses<Pd>({.kp = -1}, "kp"));
template <class Block, class... Keys>
::testing::AssertionResult Refuses(const internal::ParamsOf<Block>& params, const Keys&... keys) {
  return Throws<ParameterError>([&] { Block block(params); }, keys...);
}

}  // namespace tenon
