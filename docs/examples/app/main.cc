// A custom app: it runs the cart of the example `cart` from scenario files. It has the command line, outputs,
// report, exit codes and campaigns of Tenon's apps.

#include <tenon/apps/common/scenario_app.h>
#include <tenon/systems/simulation.h>

#include "../cart/cart.h"

namespace apps = tenon::apps;

// The keys of a scenario, in addition to those of all scenarios (duration_s, seed, report, ...).
struct CartScenario : apps::AppScenario {
  double mass_kg = 2;
  double stiffness_N_per_m = 10;
  double damping_N_s_per_m = 6;
  double goal_m = 0.2;  ///< goal position from t = 1 s on
  static tenon::FieldList Fields() {
    return With({{"mass_kg", &CartScenario::mass_kg},
                 {"stiffness_N_per_m", &CartScenario::stiffness_N_per_m},
                 {"damping_N_s_per_m", &CartScenario::damping_N_s_per_m},
                 {"goal_m", &CartScenario::goal_m}});
  }
};

apps::RunResult Run(const CartScenario& scenario, const apps::RunOptions& options) {
  tenon::DiagramBuilder builder;
  auto& cart = apps::Blame("mass_kg",
                           [&]() -> Cart& { return builder.Add<Cart>("cart", {.mass = scenario.mass_kg}); });
  auto& pd = builder.Add<Pd>("pd", {.kp = scenario.stiffness_N_per_m, .kd = scenario.damping_N_s_per_m});
  auto& ref = builder.AddFunction({"ref", "m"}, tenon::Uses(builder.time),
                                  [goal = scenario.goal_m](double t) { return t < 1 ? 0.0 : goal; });
  builder.Connect(cart.state, pd.x);
  builder.Connect(ref, pd.ref);
  builder.Connect(pd.u, cart.force);
  const auto diagram = builder.Build();

  tenon::Simulator simulator(*diagram, {.order = 3, .rtol = 1e-6, .seed = scenario.seed});
  return apps::RunScenario(options, scenario, "a cart under a PD controller", scenario.duration_s, simulator,
                           {&cart.state, &ref, &pd.u}, {&cart.geometry}, {}, [&](apps::Summary& summary) {
                             summary.Set("error_end_m",
                                         scenario.goal_m - simulator.context().Eval(cart.state)[0]);
                           });
}

int main(int argc, char** argv) {
  return apps::RunApp(apps::MakeScenarioApp("cart-app", "Moves a cart to its goal.", Run), argc, argv);
}
