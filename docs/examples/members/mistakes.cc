// The commonest mistake with each member, and the error that it gives.

#include <tenon/systems/report/campaign_report.h>
#include <tenon/systems/simulation.h>

#include <cstdio>
#include <functional>
#include <stdexcept>
#include <string>

using namespace tenon;

bool all_good = true;

/// Expects that `act` throws an error that contains `message`.
void Expect(const char* message, const std::function<void()>& act) {
  std::string text = "no error";
  try {
    act();
  } catch (const Error& error) {
    text = error.what();
  }
  const bool good = text.find(message) != std::string::npos;
  all_good &= good;
  std::printf("%s%s\n", good ? "" : "UNEXPECTED: ", text.c_str());
}

void RunDiagram(DiagramBuilder& builder) {
  Simulator(builder.Build()).RunTo(3);
}

/// Runs a block for three seconds.
template <class Block>
void Run() {
  DiagramBuilder builder;
  builder.Add<Block>("block");
  RunDiagram(builder);
}

struct UsesBelow final : LeafSystem<void> {
  OutputPort<double> y{this, "y", Uses(x), [](double x) { return 2 * x; }};
  DiscreteState<double> x{this, "x"};
};

struct NoDerivative final : LeafSystem<void> {
  ContinuousState<double> x{this, "x"};
};

struct TwoRates final : LeafSystem<void> {
  DiscreteState<double> n{this, "n"};
  Update<double> fast{n, Sampled{Hz(100)}, Uses(n), [](double n) { return n + 1; }};
  Update<double> reset{n, Sampled{Hz(1)}, Uses(), [] { return 0.0; }};
};

struct SpringParams {
  double stiffness = 4;
  void Validate() const { Demand(stiffness > 0, "stiffness must be positive"); }
};
struct Spring final : LeafSystem<SpringParams> {
  Parameter<double> stiffness{this, {"stiffness", "N/m"}, params.stiffness};
};

struct ThroughShared final : LeafSystem<void> {
  InputPort<double> u{this, "u"};
  ContinuousState<double> x{this, "x"};
  Shared<Vec<2>> both{this, "both", Uses(x, u), [](double x, double u) { return Vec<2>(2 * x, u - x); }};
  TimeDerivative<double> dx{x, Uses(both), [](const Vec<2>& both) { return both[1]; }};
  OutputPort<double> y{this, "y", Uses(both), [](const Vec<2>& both) { return both[0]; }};
};

struct Two final : LeafSystem<void> {
  InputPorts<double> u{this, "u", 2};
  OutputPort<double> y{this, "y", Uses(u), [](const Inputs<double>& u) { return u[0] + u[1]; }};
};

struct SharedScratch final : LeafSystem<void> {
  Scratch<double> last{this, "last"};
  OutputPort<double> y{this, "y", Uses(time, last), [](double t, double& last) { return last = t; }};
  OutputPort<double> z{this, "z", Uses(last), [](double& last) { return last; }};
};

struct SharedWorkspace final : LeafSystem<void> {
  Workspace<double> work{this, "work"};
  OutputPort<double> y{this, "y", Uses(time, work), [](double t, double& work) { return work = t; }};
  OutputPort<double> z{this, "z", Uses(work), [](double& work) { return work; }};
};

struct NoiseAtAnyTime final : LeafSystem<void> {
  Random random{this, "random"};
  OutputPort<double> y{this, "y", Uses(random), [](RandomStream& random) { return random.Normal(); }};
};

struct NeverRests final : LeafSystem<void> {
  ContinuousState<Vec<2>> x{this, "x", Vec<2>(1, 0)};
  TimeDerivative<Vec<2>> dx{x, Uses(x), [](const Vec<2>& x) { return Vec<2>(x[1], -9.81); }};
  Witness floor{this, "floor", Crossing::kFalling, Uses(x), [](const Vec<2>& x) { return x[0]; }};
  Update<Vec<2>> bounce{x, floor, Uses(x), [](const Vec<2>& x) { return Vec<2>(x[0], -0.5 * x[1]); }};
};

enum class Heater { kOff, kOn };
struct TwoForOne final : LeafSystem<void> {
  Mode<Heater> heater{this, "heater"};
  Witness noon{this, "noon", Crossing::kRising, Uses(time), [](double t) { return t - 12; }};
  Update<Heater> off{heater, noon, Uses(), [] { return Heater::kOff; }};
  Update<Heater> on{heater, noon, Uses(), [] { return Heater::kOn; }};
};

struct Sensor final : LeafSystem<void> {
  OutputPort<double> y{this, "y", Sampled{Hz(10)}, Uses(time), [](double t) { return t; }};
};
struct StartsAtInput final : LeafSystem<void> {
  InputPort<double> u{this, "u"};
  DiscreteState<double> x{this, "x"};
  Update<double> begin{x, AtStart{}, Uses(u), [](double u) { return u; }};
};

struct JumpsNow final : LeafSystem<void> {
  NextJump next{this, "next", Uses(time), [](double t) { return t <= 1 ? 1.0 : kNever; }};
  ContinuousState<double> x{this, "x"};
  TimeDerivative<double> dx{x, Uses(time), [](double t) { return t < 1 ? 0.0 : 1.0; }};
};

struct Slides final : LeafSystem<void> {
  ContinuousState<double> x{this, "x", 1.0};
  Kink side{this, "side", Uses(x), [](double x) { return x > 0 ? 1 : 0; }};
  TimeDerivative<double> dx{x, Uses(x), [](double x) { return x > 0 ? -1.0 : 1.0; }};
};

struct Tank final : LeafSystem<void> {
  Monitor full{this, "full", Sampled{Hz(10)}, Uses(time),
               [](double t) { return t > 2.25 ? Verdict("the tank is full") : Verdict(); }};
};

struct Log final : LeafSystem<void> {
  Publish write{this, "write", Sampled{Hz(10)}, Uses(time), [](double t) {
                  if (t > 0.15) throw std::runtime_error("the disk is full");
                }};
};

struct Hollow final : Subdiagram {
  OutputPort<double> y{this, "y"};
};

int main() {
  Expect("inside 'block': 'y' uses member 1 of its Uses(...), which is declared below it", Run<UsesBelow>);
  Expect("continuous state 'block.x' has no time derivative: declare a TimeDerivative", Run<NoDerivative>);
  Expect("state 'block.n' has two sampled updates: merge them into one", Run<TwoRates>);
  Expect("parameter 'block.stiffness' cannot be set: stiffness must be positive", [] {
    DiagramBuilder builder;
    auto& block = builder.Add<Spring>("block");
    builder.Build()->CreateContext()->Set(block.stiffness, -1);
  });
  Expect("algebraic loop: 'block.both' uses 'block.y' uses 'block.both'.", [] {
    DiagramBuilder builder;
    auto& block = builder.Add<ThroughShared>("block");
    builder.Connect(block.y, block.u);
    builder.Build();
  });
  Expect("input 'block.u_1' is not connected", [] {
    DiagramBuilder builder;
    auto& block = builder.Add<Two>("block");
    builder.Connect(builder.Add<Sensor>("sensor").y, block.u[0]);
    builder.Build();
  });
  Expect("scratch 'block.last' is used by both 'y' and 'z': it belongs to one calculation",
         Run<SharedScratch>);
  Expect("workspace 'block.work' is used by both 'y' and 'z': it belongs to one calculation",
         Run<SharedWorkspace>);
  Expect("'block.y' uses the random stream 'random' but is not a sampled output or update",
         Run<NoiseAtAnyTime>);
  Expect("events of witness 'block.floor' accumulate at t = ", Run<NeverRests>);
  Expect("state 'block.heater' has two updates with the same trigger: merge them into one", Run<TwoForOne>);
  Expect("sampled output 'sensor.y' is read at t = 0 s before it has run", [] {
    DiagramBuilder builder;
    builder.Connect(builder.Add<Sensor>("sensor").y, builder.Add<StartsAtInput>("block").u);
    RunDiagram(builder);
  });
  Expect("'block.next' is 1 s at t = 1 s: a next jump must be later than the time, or kNever", Run<JumpsNow>);
  Expect("changes of kink 'block.side' occur 101 times at one instant", Run<Slides>);
  Expect("the run ended at t = 2.3 s: block.full: the tank is full", Run<Tank>);
  Expect("'block.write' failed at t = 0.2 s: the disk is full", Run<Log>);
  Expect("output 'block.y' of a nested diagram has nothing connected to it inside", Run<Hollow>);
  Expect("CampaignReport: run 0 has 1 figures, but the report names 2", [] {
    const CampaignReport report{.figures = {"range_m", "height_m"}, .runs = {{.figures = {12.5}}}};
    report.Write("mistake.html");
  });
  return all_good ? 0 : 1;
}
