#pragma once

#include <tenon/systems/live/live_server.h>
#include <tenon/tests/systems/framework/test_blocks.h>

namespace tenon::test {

struct EngineParams {
  double force = 0;  // N
};
enum class Gear { kLow, kHigh };
/// A force set by a parameter, with noise: the run depends on every command and on the seed.
class Engine final : public LeafSystem<EngineParams> {
 public:
  using LeafSystem::LeafSystem;
  Parameter<double> force{this, {"force", "N"}, params.force, "of the engine", Range().Between(-10, 10)};
  Parameter<Vec<2>> tilt{this, {"tilt", "rad", "roll,pitch"}, Vec<2>::Zero(), "of nothing"};
  Parameter<Gear> gear{this, {"gear"}, Gear::kLow, "of nothing"};
  Random random{this, "random"};
  OutputPort<double> u{
      this, {"u", "N"}, Sampled{Hz(100)}, Uses(force, random), [](double force, RandomStream& r) {
        return force + r.Uniform(-1, 1);
      }};
};

/// The shape of a cart.
class CartView final : public LeafSystem<void> {
 public:
  InputPort<Vec<2>> x{this, {"x", "m, m/s"}};
  OutputPort<Geometry> geometry{this,
                                {"geometry"},
                                {Shape::Box(ShapeRole::kBody, "cart", {.3, .2, .1})},
                                Uses(x),
                                [](const Vec<2>& x, Geometry* out) {
                                  (*out)[0].p_W = {x[0], 0, 0.05};
                                }};
};

/// A cart that an engine pushes.
struct LiveCart {
  LiveCart() {
    cart = &builder.Add<Cart>("cart");
    engine = &builder.Add<Engine>("engine", EngineParams{});
    auto& look = builder.Add<CartView>("view");
    builder.Connect(engine->u, cart->force);
    builder.Connect(cart->state, look.x);
    diagram = builder.Build();
    view.signals = {&cart->state, &engine->u};
    view.shapes = {&look.geometry};
    view.title = "cart";
    view.controls.drive = {{-1, 1}, {0, 0}, {0, 0}, [](const Vec<3>& velocity) {
                             return LiveSets{{"engine.force", {5 * velocity[0]}}};
                           }};
    view.controls.load = {"brick", {1, 2}, 1, [this](Context& context, double mass) {
                            const Vec<2>& x = context.Eval(cart->x);
                            return LiveSets{{"cart.x", {x[0], x[1] / (1 + mass)}}};
                          }};
  }
  DiagramBuilder builder;
  Cart* cart;
  Engine* engine;
  std::shared_ptr<const Diagram> diagram;
  LiveView view;
};

}  // namespace tenon::test
