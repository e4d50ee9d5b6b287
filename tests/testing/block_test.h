#pragma once

// The headers that tests of blocks share.

#include <tenon/tests/testing/allocation_guard.h>
#include <tenon/tests/testing/expect_throws.h>
#include <tenon/tests/testing/matchers.h>
#include <tenon/tests/testing/test_rig.h>

namespace tenon {

namespace test {

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();
inline constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

}  // namespace test

/// Tests that build a diagram.
struct DiagramTest : ::testing::Test {
  DiagramBuilder builder;
};

/// The value of a port or state after a run of what was built.
template <class S>
typename S::Value ValueAt(double time, DiagramBuilder& builder, const S& source,
                          const SimulatorOptions& options = {}) {
  Simulator simulator(builder.Build(), options);
  simulator.RunTo(time);
  return simulator.context().Eval(source);
}
/// Returns whether a run of 1 s of what was built ends with a RunError that names all the `parts`.
template <class... Parts>
::testing::AssertionResult RunFails(DiagramBuilder& builder, const Parts&... parts) {
  Simulator simulator(builder.Build());
  return Throws<RunError>([&] { simulator.RunTo(1); }, parts...);
}

/// Returns whether the constructor of a Block throws a ParameterError that names all the `keys`.
///
///     EXPECT_TRUE(Refuses<Pd>({.kp = -1}, "kp"));
template <class Block, class... Keys>
::testing::AssertionResult Refuses(const internal::ParamsOf<Block>& params, const Keys&... keys) {
  return Throws<ParameterError>([&] { Block block(params); }, keys...);
}

/// Makes a function that changes `params` and returns whether the constructor of a Block then throws a
/// ParameterError that names all the keys.
///
///     const auto refuses = RefusesChanged<Pd>({.kp = 3, .kd = 1});
///     EXPECT_TRUE(refuses([](auto& p) { p.kd = -1; }, "kd"));
template <class Block>
auto RefusesChanged(const internal::ParamsOf<Block>& params) {
  return [params](const auto& change, const auto&... keys) {
    internal::ParamsOf<Block> changed = params;
    change(changed);
    return Refuses<Block>(changed, keys...);
  };
}

}  // namespace tenon
