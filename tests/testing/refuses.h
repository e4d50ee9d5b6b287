#pragma once

#include <tenon/systems/framework/diagram/diagram_builder.h>
#include <tenon/systems/framework/types/errors.h>
#include <tenon/tests/testing/expect_throws.h>

#include <limits>
#include <string>
#include <utility>

namespace tenon::test {

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();
inline constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// Checks that the constructor of a block refuses these parameters by a ParameterError that names `key`.
///
///     EXPECT_TRUE(test::Refuses<Gain<>>({.gain = test::kNan}, "gain"));
template <class Block>
::testing::AssertionResult Refuses(internal::ParamsOf<Block> params, const std::string& key) {
  return Throws<ParameterError>([&] { Block block(std::move(params)); }, key);
}

}  // namespace tenon::test
