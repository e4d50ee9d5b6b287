#pragma once

/// @file
/// Everything needed to build a diagram of blocks and to run it.
///
///     #include <tenon/systems/simulation.h>
///
///     tenon::DiagramBuilder builder;
///     auto& cart = builder.Add<Cart>("cart", CartParams{.mass = 2});
///     auto& pd = builder.Add<Pd>("pd");
///     builder.Connect(cart.state, pd.x);
///     builder.Connect(pd.u, cart.force);
///     const auto diagram = builder.Build();
///
///     tenon::Simulator simulator(*diagram, {.order = 3, .rtol = 1e-6});
///     const auto log = simulator.AddLog(tenon::Hz(100), {&cart.state, &pd.u});
///     simulator.RunTo(10);

// First, because compiler errors then list fewer headers.
// clang-format off
// clang-format on

#include <tenon/systems/block.h>
#include <tenon/systems/simulation/simulator.h>
