// Members that end a run, send values out of it or take values into it, a block made of blocks, and the
// report of many runs.

#include <tenon/systems/block.h>
#include <tenon/systems/campaign/statistics.h>
#include <tenon/systems/io/external_input.h>
#include <tenon/systems/primitives/integrator.h>
#include <tenon/systems/report/campaign_report.h>
#include <tenon/tests/testing/test_rig.h>

#include "near.h"

#include <algorithm>
#include <cmath>
#include <vector>

using namespace tenon;

// A tank that fills by 0.2 m/s. The run ends when the level is above 0.45 m.
class Tank final : public LeafSystem<void> {
 public:
  ContinuousState<double> level{this, {"level", "m"}};
  TimeDerivative<double> inflow{level, Uses(), [] { return 0.2; }};
  Monitor full{this, "full", Sampled{Hz(10)}, Uses(level), [](double level) -> Verdict {
                 if (level <= 0.45) return {};
                 return "the level is " + std::to_string(level) + " m";
               }};
};

bool CheckMonitor() {
  DiagramBuilder builder;
  builder.Add<Tank>("tank");
  Simulator simulator(builder.Build());
  const RunStatus status = simulator.AdvanceTo(10);
  std::printf("%s\n", status.reason.c_str());
  return Near("Monitor", status.time, 2.3) && status.ended;  // the first tick after 0.45 / 0.2 = 2.25 s
}

struct DisplayParams {
  std::vector<double>* shown = nullptr;  // stands for a window, a file or a socket
};
// Shows a value ten times a second.
class Display final : public LeafSystem<DisplayParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPort<double> u{this, {"u", "m"}};
  Publish show{this, "show", Sampled{Hz(10)}, Uses(time, u),
               [this](double t, double u) { params.shown->push_back(t * u); }};
};

bool CheckPublish() {
  std::vector<double> shown;
  TestRig<Display> rig({.shown = &shown});
  rig.Fix(rig->u, 3).RunTo(1);
  return Near("Publish", shown.back(), 3) && shown.size() == 11;
}

bool CheckExternalInput() {
  DiagramBuilder builder;
  auto& force = builder.Add<ExternalInput<double>>("force", {.rate = Hz(10), .unit = "N"});
  auto& impulse = builder.Add<Integrator<double>>("impulse");
  builder.Connect(force.y, impulse.u);
  Simulator simulator(builder.Build());
  simulator.RunTo(1);
  force.Put(3);  // from any thread; the tick at 1.1 s takes it over
  simulator.RunTo(2);
  return Near("ExternalInput", simulator.context().Eval(impulse.y), 3 * (2 - 1.1));
}

// A motor with a proportional controller: x' = 2 (goal - x).
class Servo final : public Subdiagram {
 public:
  InputPort<double> goal{this, {"goal", "m"}};
  OutputPort<double> position{this, {"position", "m"}};
  Servo() {
    auto& motor = Add<Integrator<double>>("motor");
    auto& speed = AddFunction({"speed", "m/s"}, Uses(goal, motor.y),
                              [](double goal, double x) { return 2 * (goal - x); });
    Connect(speed, motor.u);
    Connect(motor.y, position);
  }
};

bool CheckSubdiagram() {
  TestRig<Servo> rig;
  rig.Fix(rig->goal, 1).RunTo(1);
  return Near("Subdiagram", rig[rig->position], 1 - std::exp(-2));
}

bool CheckCampaignReport() {
  CampaignReport report{.title = "A thousand throws", .drawn = {"speed_m_per_s"}, .figures = {"range_m"}};
  for (std::size_t run = 0; run < 1000; ++run) {
    const double speed = RandomStream(run, "speed").Uniform(8, 12), range = speed * speed / 9.81;
    report.runs.push_back({.index = run,
                           .drawn = {speed},
                           .figures = {range},
                           .survived = range > 10,
                           .reason = range > 10 ? "" : "too short by " + std::to_string(10 - range) + " m"});
  }
  report.Write("throws.html");
  const double fails = (std::sqrt(98.1) - 8) / (12 - 8);  // probability that speed^2 / 9.81 is at most 10 m
  const auto causes = report.Causes();  // one: reasons that differ only in numbers are equal
  const Interval interval = WilsonInterval(causes[0].count, report.runs.size(), 0.99);
  return Near("CampaignReport", 0.5 * (interval.low + interval.high), fails, 0.5 * interval.width()) &&
         causes.size() == 1;
}

int main() {
  const bool good[] = {CheckMonitor(), CheckPublish(), CheckExternalInput(), CheckSubdiagram(),
                       CheckCampaignReport()};
  return std::ranges::find(good, false) == std::end(good) ? 0 : 1;
}
