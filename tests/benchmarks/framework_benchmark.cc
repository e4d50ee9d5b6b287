// Overhead of the framework, compared with a list of virtual calls that computes the same values.
//
//   ring/N, ring_bare/N     time derivatives of a ring of N blocks (integrator, gain, adder in turn), with
//                           a new state in each call; both versions give the same numbers
//   gain_chain/100          an output behind 100 gains, after a change of the input
//   pd_loop                 one tick of a 1 kHz PD controller on a double integrator, order 3 adaptive
//   clone_context/1000      copying a context of 1000 blocks
//   build_diagram/1000      making 1000 blocks, connecting and compiling them

#include <tenon/systems/primitives/adder.h>
#include <tenon/systems/primitives/gain.h>
#include <tenon/systems/primitives/integrator.h>
#include <tenon/systems/simulation/simulator.h>

#include <benchmark/benchmark.h>

namespace tenon {
namespace {

constexpr double kGain = -0.5;

/// A closed ring: integrator 1 -> gain 1 -> adder 1 -> integrator 2 -> …. Each adder also adds the output of
/// its own integrator.
struct Ring {
  explicit Ring(int blocks) {
    std::vector<Integrator<double>*> integrators;
    std::vector<Adder<double>*> adders;
    for (int i = 0; i < blocks; i += 3) {
      const std::string number = std::to_string(i / 3);
      IntegratorParams<double> start;
      start.initial = 1 + 0.1 * i;
      auto& integrator = builder.Add<Integrator<double>>("integrator" + number, start);
      auto& gain = builder.Add<Gain<double>>("gain" + number, GainParams{.gain = kGain});
      auto& adder = builder.Add<Adder<double>>("adder" + number, AdderParams{.weights = {1, 1}});
      builder.Connect(integrator.y, gain.u);
      builder.Connect(gain.y, adder.u[0]);
      builder.Connect(integrator.y, adder.u[1]);
      integrators.push_back(&integrator);
      adders.push_back(&adder);
    }
    for (std::size_t i = 0; i < adders.size(); ++i) {
      builder.Connect(adders[i]->y, integrators[(i + 1) % integrators.size()]->u);
    }
  }
  DiagramBuilder builder;
};

struct BareBlock {
  virtual ~BareBlock() = default;
  virtual void Run() = 0;
};
struct BareGain final : BareBlock {
  const double* u;
  double y;
  void Run() override { y = kGain * *u; }
};
struct BareAdder final : BareBlock {
  const double *a, *b;
  double y;
  void Run() override { y = *a + *b; }
};
struct BareIntegrator final : BareBlock {
  const double* u;
  double* derivative;
  void Run() override { *derivative = *u; }
};

struct BareRing {
  explicit BareRing(int blocks) {
    const int n = (blocks + 2) / 3;
    state.resize(n);
    derivative.resize(n);
    std::vector<BareAdder*> adders;
    for (int i = 0; i < n; ++i) {
      state[i] = 1 + 0.1 * (3 * i);
      auto gain = std::make_unique<BareGain>();
      auto adder = std::make_unique<BareAdder>();
      gain->u = &state[i];
      adder->a = &gain->y;
      adder->b = &state[i];
      adders.push_back(adder.get());
      list.push_back(std::move(gain));
      list.push_back(std::move(adder));
    }
    for (int i = 0; i < n; ++i) {
      auto integrator = std::make_unique<BareIntegrator>();
      integrator->u = &adders[(i + n - 1) % n]->y;
      integrator->derivative = &derivative[i];
      list.push_back(std::move(integrator));
    }
  }
  std::vector<double> state, derivative;
  std::vector<std::unique_ptr<BareBlock>> list;
};

/// Sets new states and evaluates the derivatives, as the simulator does at each stage of a step.
void RingDerivatives(benchmark::State& state) {
  const int blocks = static_cast<int>(state.range(0));
  Ring ring(blocks);
  const auto diagram = ring.builder.Build();
  const auto context = diagram->CreateContext();
  Eigen::VectorXd x = context->continuous_state(), dx(x.size());
  BareRing bare(blocks);
  for (auto& block : bare.list) block->Run();
  context->CalcTimeDerivatives(0, x.data(), dx.data());
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    if (dx[i] != bare.derivative[i]) state.SkipWithError("differs from the bare list");
  }
  for (auto _ : state) {
    x[0] += 1e-9;
    context->CalcTimeDerivatives(0, x.data(), dx.data());
    benchmark::DoNotOptimize(dx.data());
    benchmark::ClobberMemory();
  }
}

void BareRingDerivatives(benchmark::State& state) {
  BareRing ring(static_cast<int>(state.range(0)));
  for (auto _ : state) {
    ring.state[0] += 1e-9;
    for (auto& block : ring.list) block->Run();
    benchmark::DoNotOptimize(ring.derivative.data());
    benchmark::ClobberMemory();
  }
}

void GainChain(benchmark::State& state) {
  DiagramBuilder builder;
  std::vector<Gain<double>*> gains;
  for (int i = 0; i < state.range(0); ++i) {
    gains.push_back(&builder.Add<Gain<double>>("gain" + std::to_string(i), GainParams{.gain = 1.001}));
    if (i > 0) builder.Connect(gains[gains.size() - 2]->y, gains.back()->u);
  }
  auto& sink = builder.Add<Integrator<double>>("sink");
  auto& source = builder.Add<Integrator<double>>("source");
  builder.Connect(source.y, gains.front()->u);
  builder.Connect(gains.back()->y, sink.u);
  builder.Connect(sink.y, source.u);
  const auto context = builder.Build()->CreateContext();
  Eigen::VectorXd x = Eigen::VectorXd::Ones(2), dx(2);
  double expected = x[1];
  for (std::size_t i = 0; i < gains.size(); ++i) expected *= 1.001;
  context->CalcTimeDerivatives(0, x.data(), dx.data());
  if (dx[0] != expected) state.SkipWithError("differs from bare multiplications");
  for (auto _ : state) {
    x[1] += 1e-9;
    context->CalcTimeDerivatives(0, x.data(), dx.data());
    benchmark::DoNotOptimize(dx.data());
    benchmark::ClobberMemory();
  }
}

class Pd final : public LeafSystem<void> {
 public:
  InputPort<Vec<2>> x{this, {"x", "m, m/s"}};
  OutputPort<double> u{this, {"u", "N"}, Sampled{Hz(1000)}, Uses(x), &Pd::CalcU};

 private:
  double CalcU(const Vec<2>& x) const { return 10 * (0.2 - x[0]) - 2 * x[1]; }
};
class Cart final : public LeafSystem<void> {
 public:
  InputPort<double> force{this, {"force", "N"}};
  ContinuousState<Vec<2>> x{this, {"x", "m, m/s"}};
  OutputPort<Vec<2>> state{this, x};
  TimeDerivative<Vec<2>> dx{x, Uses(x, force), &Cart::CalcDx};

 private:
  Vec<2> CalcDx(const Vec<2>& x, const double& force) const { return {x[1], force / 2}; }
};

void PdLoop(benchmark::State& state, const SimulatorOptions& options) {
  DiagramBuilder builder;
  auto& cart = builder.Add<Cart>("cart");
  auto& pd = builder.Add<Pd>("pd");
  builder.Connect(cart.state, pd.x);
  builder.Connect(pd.u, cart.force);
  Simulator simulator(builder.Build(), options);
  simulator.RunTo(1);
  constexpr int kTicks = 1000;
  double end = 1;
  for (auto _ : state) {
    end += kTicks * 1e-3;
    simulator.RunTo(end);
  }
  state.counters["per_tick"] = benchmark::Counter(static_cast<double>(state.iterations()) * kTicks,
                                                  benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
  state.counters["evaluations_per_tick"] =
      static_cast<double>(simulator.statistics().evaluations) / (1000 * end);
}

void CloneContext(benchmark::State& state) {
  Ring ring(static_cast<int>(state.range(0)));
  const auto diagram = ring.builder.Build();
  const auto context = diagram->CreateContext();
  for (auto _ : state) benchmark::DoNotOptimize(context->Clone());
}

void BuildDiagram(benchmark::State& state) {
  for (auto _ : state) {
    Ring ring(static_cast<int>(state.range(0)));
    benchmark::DoNotOptimize(ring.builder.Build());
  }
}

BENCHMARK(RingDerivatives)->Name("ring")->Arg(10)->Arg(100)->Arg(1000);
BENCHMARK(BareRingDerivatives)->Name("ring_bare")->Arg(10)->Arg(100)->Arg(1000);
BENCHMARK(GainChain)->Name("gain_chain")->Arg(100);
BENCHMARK_CAPTURE(PdLoop, open, SimulatorOptions{.method = Method::kErkOpen})->Name("pd_loop");
BENCHMARK_CAPTURE(PdLoop, defaults, SimulatorOptions{})->Name("pd_loop_default");
BENCHMARK(CloneContext)->Name("clone_context")->Arg(1000);
BENCHMARK(BuildDiagram)->Name("build_diagram")->Arg(1000)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace tenon
