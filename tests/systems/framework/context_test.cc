#include <tenon/tests/systems/framework/test_blocks.h>
#include <tenon/tests/testing/temporary_path.h>

#include <random>
#include <thread>

namespace tenon::context_test {

using ::testing::HasSubstr, ::testing::ThrowsMessage;

// ---- Values by hand ----

using ContextTest = DiagramTest;

TEST_F(ContextTest, SetMakesWhatDependsOnItStale) {
  auto& cart = builder.Add<Cart>("cart");
  auto& twice = builder.AddFunction("twice", Uses(cart.state), [](const Vec<2>& x) { return 2 * x[0]; });
  auto& four =
      builder.AddFunction("four", Uses(twice, builder.time), [](double u, double t) { return 2 * u + t; });
  const auto context = builder.BuildWithOpenInputs()->CreateContext();
  EXPECT_EQ(context->Eval(four), 0);
  context->Set(cart.x, Vec<2>(3, 1));
  EXPECT_EQ(context->Eval(four), 12);
  context->SetTime(0.5);
  EXPECT_EQ(context->Eval(four), 12.5);
  context->SetContinuousState(Eigen::Vector2d(1, 0));
  EXPECT_EQ(context->Eval(twice), 2);
  context->Set(cart.force, 6.0);
  EXPECT_EQ(context->EvalTimeDerivatives(), Eigen::Vector2d(0, 3));
}

TEST_F(ContextTest, EachValueIsComputedOnceUntilSomethingChanges) {
  int calls = 0;
  auto& cart = builder.Add<Cart>("cart");
  auto& counted = builder.AddFunction("counted", Uses(cart.state), [&calls](const Vec<2>& x) {
    ++calls;
    return x[0];
  });
  const auto context = builder.BuildWithOpenInputs()->CreateContext();
  context->Eval(counted);
  context->Eval(counted);
  EXPECT_EQ(calls, 1);
  context->Set(cart.x, Vec<2>(1, 1));
  EXPECT_EQ(calls, 1);  // on demand only
  context->Eval(counted);
  EXPECT_EQ(calls, 2);
}

TEST_F(ContextTest, ComputedValuesCannotBeSet) {
  auto& f = builder.AddFunction("f", Uses(builder.time), [](double t) { return t; });
  const auto context = builder.Build()->CreateContext();
  EXPECT_TRUE(Throws<RunError>([&] { context->Set(f, 1.0); }, "'f.output'"));
}

TEST_F(ContextTest, DoublesByPath) {
  auto& cart = builder.Add<Cart>("cart");
  const auto diagram = builder.BuildWithOpenInputs();
  const auto context = diagram->CreateContext();
  const double wrong[] = {1, 2, 3}, right[] = {1, 2};
  EXPECT_TRUE(Throws<RunError>([&] { context->SetDoubles(diagram->Find("cart.x"), wrong); }, "'cart.x'"));
  context->SetDoubles(cart.x, right);
  EXPECT_EQ(context->EvalDoubles(cart.state), (std::vector<double>{1, 2}));
  EXPECT_THROW(context->SetDoubles(cart.force, right), RunError);
  EXPECT_THAT([&] { context->Eval(cart.force); },  // a refused value does not count
              ThrowsMessage<RunError>(HasSubstr("'cart.force'")));
  EXPECT_TRUE(
      Throws<RunError>([&] { context->SetContinuousState(Eigen::Vector3d::Zero()); }, "2 continuous states"));
}

TEST_F(ContextTest, SourcesOfAnotherDiagramAreRefused) {
  DiagramBuilder other;
  builder.Add<Oscillator>("mine");
  auto& theirs = other.Add<Oscillator>("theirs");
  const auto diagram = builder.Build(), other_diagram = other.Build();
  EXPECT_TRUE(Throws<RunError>([&] { diagram->CreateContext()->Eval(theirs.x); }, "'theirs.x'"));
}

TEST_F(ContextTest, DerivativesRefuseSamplesThatHaveNotRun) {
  PdLoop loop;
  const auto context = loop.builder.Build()->CreateContext();
  EXPECT_TRUE(Throws<RunError>([&] { context->EvalTimeDerivatives(); }, "'pd.u'"));
  context->Set(loop.pd.u, 2.0);
  EXPECT_EQ(context->EvalTimeDerivatives()[1], 1);
}

// ---- A diagram with everything that a context holds ----

enum class Gait { kStand, kWalk };

struct Report {
  double cost = 0;
  std::vector<double> history;
  std::string word;
  static FieldList Fields() {
    return {{"cost", &Report::cost}, {"history", &Report::history}, {"word", &Report::word}};
  }
};

/// A controller with noise, a warm start, a mode and a delay.
struct Busy final : LeafSystem<Rate> {
  explicit Busy(Rate rate) : LeafSystem(rate) {}
  InputPort<Vec<2>> x{this, "x"};
  InputPort<double> ref{this, "ref", 0.3};
  Random random{this, "random"};
  Scratch<Eigen::VectorXd> warm{this, "warm", Eigen::VectorXd::Constant(2, 1.0)};
  Workspace<std::vector<double>> workspace{this, "workspace", std::vector<double>(4)};
  OutputPort<double> noise{this, "noise", Sampled{params}, Uses(random),
                           [](RandomStream& r) { return r.Normal(); }};
  OutputPort<double> u{this, "u", Sampled{params}, Uses(x, ref, noise, warm, workspace), &Busy::CalcU};
  OutputPort<double> late{this, "late", 0.5, Sampled{params, 0.0125}, Uses(u), [](double u) { return u; }};
  DiscreteState<double> memory{this, "memory"};
  OutputPort<double> delayed{this, memory};
  Update<double> remember{memory, Sampled{params}, Uses(u), [](double u) { return u; }};
  Mode<Gait> gait{this, "gait"};
  Update<Gait> change{gait, Sampled{Hz(7)}, Uses(gait),
                      [](Gait g) { return g == Gait::kWalk ? Gait::kStand : Gait::kWalk; }};
  OutputPort<double> sign{this, "sign", Uses(gait), [](Gait g) { return g == Gait::kWalk ? 1.0 : -1.0; }};
  DiscreteState<Report> report{this, "report", Report{1, {1}, "a"}};
  Update<Report> extend{report, Sampled{Hz(10)}, Uses(report, u), &Busy::Extend};

 private:
  double CalcU(const Vec<2>& x, double ref, double noise, Eigen::VectorXd& warm,
               std::vector<double>& work) const {
    // The iteration does not converge, so the result depends on the warm start.
    work[0] = 8 * (ref - x[0]) - x[1] + 0.1 * noise;
    warm = 0.5 * warm + 0.25 * Eigen::VectorXd::Constant(2, work[0]);
    return warm.sum();
  }
  Report Extend(const Report& report, double u) const {
    Report next = report;
    next.history.push_back(u);
    next.word += "b";
    next.cost += u * u;
    return next;
  }
};

TEST_F(ContextTest, ElementsAreThoseOfThePresentValue) {
  auto& busy = builder.Add<Busy>("busy", Hz(10));
  const auto diagram = builder.BuildWithOpenInputs();
  const auto context = diagram->CreateContext();
  context->Set(busy.warm, Eigen::Vector3d(1, 2, 3));  // scratch can be set
  EXPECT_EQ(context->EvalDoubles(busy.warm), (std::vector<double>{1, 2, 3}));
  EXPECT_EQ(busy.warm.elements().size(), 2);
  ASSERT_EQ(context->Elements(busy.warm).size(), 3);
  EXPECT_EQ(context->Elements(busy.warm)[2].name, "z");
  EXPECT_TRUE(context->Elements(busy.warm)[2].is_real);
  EXPECT_FALSE(context->Elements(busy.gait)[0].is_real);
}

/// Its output is continuous and has a warm start.
struct WarmMap final : LeafSystem<void> {
  InputPort<double> u{this, "u"};
  Scratch<double> warm{this, "warm"};
  OutputPort<double> y{this, "y", Uses(u, warm), [](double u, double& w) { return w = 0.5 * w + u; }};
};

struct Rich {
  Rich() {
    DiagramBuilder builder;
    plant = &builder.Add<Oscillator>("plant", 6.0);
    slow = &builder.Add<Busy>("slow", Hz(40));
    fast = &builder.Add<Busy>("fast", Hz(90));
    held = &builder.Add<WarmMap>("held");
    varying = &builder.Add<WarmMap>("varying");
    reads_both = &builder.AddFunction("reads_both", Sampled{Hz(90)}, Uses(held->y, varying->y),
                                      [](double a, double b) { return a + b; });
    builder.Connect(plant->state, slow->x);
    builder.Connect(plant->state, fast->x);
    builder.Connect(slow->u, held->u);
    builder.Connect(builder.AddFunction("q", Uses(plant->state), [](const Vec<2>& x) { return x[0]; }),
                    varying->u);
    builder.Connect(builder.AddFunction("force", Uses(held->y, fast->delayed, slow->late, fast->sign),
                                        [](double a, double b, double c, double d) { return a + b - c + d; }),
                    plant->u);
    diagram = builder.Build();
  }
  Oscillator* plant;
  Busy *slow, *fast;
  WarmMap *held, *varying;
  OutputPort<double>* reads_both;
  std::shared_ptr<const Diagram> diagram;

  SimulatorOptions options(std::uint64_t seed = 5) const {
    return {.rtol = 1e-5, .atol = 1e-7, .seed = seed};
  }
  /// All observable values of a run.
  std::vector<double> Digest(Simulator& simulator) const {
    Context& c = simulator.context();
    std::vector<double> all{c.time(), c.Eval(plant->x)[0], c.Eval(plant->x)[1], c.Eval(*reads_both)};
    for (Busy* busy : {slow, fast}) {
      for (const double v : {c.Eval(busy->noise), c.Eval(busy->u), c.Eval(busy->late), c.Eval(busy->memory),
                             static_cast<double>(c.Eval(busy->gait)), c.Eval(busy->report).cost,
                             static_cast<double>(c.Eval(busy->report).word.size())}) {
        all.push_back(v);
      }
      const Report report = c.Eval(busy->report);
      all.insert(all.end(), report.history.begin(), report.history.end());
    }
    return all;
  }
};

// ---- Clones ----

TEST_F(ContextTest, ClonesGoOnAloneAndAlike) {
  const Rich rich;
  Simulator original(*rich.diagram, rich.options());
  original.RunTo(0.4);
  Simulator clone(original.context().Clone(), rich.options());
  EXPECT_EQ(rich.Digest(clone), rich.Digest(original));
  const std::vector<double> before = rich.Digest(original);
  clone.RunTo(1);
  EXPECT_EQ(rich.Digest(original), before);
  original.RunTo(1);
  EXPECT_EQ(rich.Digest(clone), rich.Digest(original));
  EXPECT_NE(rich.Digest(original), before);
  EXPECT_EQ(original.context().seed(), 5);
  EXPECT_EQ(clone.context().seed(), 5);
}

// ---- Snapshots ----

TEST_F(ContextTest, RestoredRunGoesOnBitForBit) {
  const Rich rich;
  Simulator straight(*rich.diagram, rich.options());
  straight.RunTo(1);
  const std::vector<double> expected = rich.Digest(straight);
  // 0 and 0.5 s are ticks of all rates, the other times of one or two rates.
  for (const double tick : {0.0, 0.025, 0.1, 1.0 / 7, 0.5, 32.0 / 90, 0.9375 - 0.025}) {
    Simulator first(*rich.diagram, rich.options());
    first.RunTo(tick);
    const std::vector<double> at_tick = rich.Digest(first);
    const std::vector<std::byte> snapshot = first.context().Save();

    first.RunTo(1);
    EXPECT_EQ(rich.Digest(first), expected) << tick;  // looking does not disturb
    first.context().Restore(snapshot);
    EXPECT_EQ(rich.Digest(first), at_tick) << tick;
    first.RunTo(1);
    EXPECT_EQ(rich.Digest(first), expected) << tick;

    auto context = rich.diagram->CreateContext(99);  // the seed is of the snapshot
    context->Restore(snapshot);
    Simulator other(std::move(context), rich.options());
    EXPECT_EQ(other.context().Save(), snapshot) << tick;
    other.RunTo(1);
    EXPECT_EQ(rich.Digest(other), expected) << tick;
  }
}

TEST_F(ContextTest, RestoredRunGoesOnFromAFile) {
  const auto file = test::TemporaryPath("tenon_context_test.snapshot");
  std::vector<double> expected;
  {
    const Rich rich;
    Simulator simulator(*rich.diagram, rich.options());
    simulator.RunTo(0.5);
    simulator.context().SaveFile(file);
    simulator.RunTo(0.8);
    expected = rich.Digest(simulator);
  }
  const Rich rich;  // as if in another program
  auto context = rich.diagram->CreateContext();
  context->RestoreFile(file);
  Simulator simulator(std::move(context), rich.options());
  simulator.RunTo(0.8);
  EXPECT_EQ(rich.Digest(simulator), expected);
  std::filesystem::remove(file);
}

TEST_F(ContextTest, SnapshotOfAnUnstartedContextStarts) {
  const Rich rich;
  const auto snapshot = rich.diagram->CreateContext(5)->Save();
  Simulator fresh(*rich.diagram, rich.options()), restored(*rich.diagram, rich.options(6));
  restored.RunTo(0.3);
  restored.context().Restore(snapshot);
  fresh.RunTo(0.2);
  restored.RunTo(0.2);
  EXPECT_EQ(rich.Digest(restored), rich.Digest(fresh));
}

TEST_F(ContextTest, SnapshotFilesThatCannotBeUsedAreNamed) {
  builder.Add<Oscillator>("plant");
  const auto context = builder.Build()->CreateContext();
  EXPECT_TRUE(Throws<OutputError>([&] { context->SaveFile("/nonexistent/file"); }, "'/nonexistent/file'"));
  EXPECT_TRUE(Throws<RunError>([&] { context->RestoreFile("/nonexistent/file"); }, "'/nonexistent/file'"));
  const auto file = test::TemporaryPath("tenon_context_test.broken");
  std::ofstream(file) << "not a snapshot";
  EXPECT_TRUE(Throws<RunError>([&] { context->RestoreFile(file); }, file.string()));
  std::filesystem::remove(file);
}

TEST_F(ContextTest, SnapshotsThatWereChangedAreRefusedAndChangeNothing) {
  const Rich rich;
  Simulator simulator(*rich.diagram, rich.options());
  simulator.RunTo(0.3);
  const std::vector<std::byte> good = simulator.context().Save();
  simulator.RunTo(0.5);
  const std::vector<std::byte> before = simulator.context().Save();

  std::mt19937 random(1);
  const auto below = [&](std::size_t end) { return random() % end; };
  for (int i = 0; i < 400; ++i) {
    std::vector<std::byte> bad = good;
    if (i % 4 == 0) {  // a bit
      bad[below(bad.size())] ^= std::byte{1} << below(8);
    } else if (i % 4 == 1) {  // the end is missing
      bad.resize(below(bad.size()));
    } else if (i % 4 == 2) {  // one byte more
      bad.insert(bad.begin() + static_cast<std::ptrdiff_t>(below(bad.size() + 1)), std::byte(below(256)));
    } else {  // two bytes exchanged
      while (bad == good) std::swap(bad[below(bad.size())], bad[below(bad.size())]);
    }
    EXPECT_THROW(simulator.context().Restore(bad), RunError) << i;
  }
  EXPECT_EQ(simulator.context().Save(), before);
}

TEST_F(ContextTest, SnapshotsOfOtherVersionsAreNamed) {
  const Rich rich;
  const auto context = rich.diagram->CreateContext();
  std::vector<std::byte> snapshot = context->Save();
  snapshot[8] = std::byte{77};  // behind eight letters
  EXPECT_TRUE(Throws<RunError>([&] { context->Restore(snapshot); }, "77"));
}

TEST_F(ContextTest, BlocksOfOtherNamesAreAnotherDiagram) {
  DiagramBuilder ones, others;
  ones.Add<Oscillator>("one");
  others.Add<Oscillator>("other");
  const auto one = ones.Build(), other = others.Build();
  EXPECT_TRUE(Throws<RunError>([&] { one->CreateContext()->Restore(other->CreateContext()->Save()); },
                               "another diagram"));
}

/// Trivially copyable, but without Fields(): it has padding, so it is not saved as bytes.
struct Opaque {
  bool flag = false;
  double value = 0;
};

TEST_F(ContextTest, TypeThatCannotBeStoredIsNamed) {
  struct Block final : LeafSystem<void> {
    DiscreteState<Opaque> state{this, "state"};
  };
  builder.Add<Block>("block");
  const auto context = builder.Build()->CreateContext();
  EXPECT_NO_THROW(context->Clone());  // a copy is all that a clone needs
  EXPECT_TRUE(Throws<RunError>([&] { context->Save(); }, "'block.state'"));
}

// ---- Threads ----

TEST_F(ContextTest, ThreadsRunOneDiagramBitForBitLikeOneAfterTheOther) {
  const Rich rich;
  std::vector<std::vector<double>> serial(4), parallel(4);
  const auto run = [&](std::vector<double>& digest, std::uint64_t seed) {
    Simulator simulator(*rich.diagram, rich.options(seed));
    simulator.RunTo(2);
    digest = rich.Digest(simulator);
  };
  for (std::size_t i = 0; i < 4; ++i) run(serial[i], i);
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < 4; ++i) threads.emplace_back([&, i] { run(parallel[i], i); });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(parallel, serial);
  EXPECT_NE(serial[0], serial[1]);
}

// ---- Random numbers ----

struct Noise final : LeafSystem<void> {
  Random a{this, "a"}, b{this, "b"};
  OutputPort<double> y{this, "y", Sampled{Hz(1)}, Uses(a), [](RandomStream& r) { return r.Uniform(); }};
  OutputPort<double> z{this, "z", Sampled{Hz(1)}, Uses(b), [](RandomStream& r) { return r.Uniform(); }};
};

TEST_F(ContextTest, BlocksHaveIndependentStreamsByTheirPath) {
  const auto values = [](std::vector<std::string> names) {
    DiagramBuilder fresh;
    std::vector<const Noise*> blocks;
    for (const std::string& name : names) blocks.push_back(&fresh.Add<Noise>(name));
    Simulator simulator(fresh.Build());
    simulator.Initialize();
    std::vector<double> values;
    for (const Noise* block : blocks) {
      values.push_back(simulator.context().Eval(block->y));
      values.push_back(simulator.context().Eval(block->z));
    }
    return values;
  };
  const std::vector<double> one = values({"left"}), two = values({"right", "left"});
  EXPECT_EQ(one[0], two[2]);  // whatever else there is
  EXPECT_NE(two[0], two[2]);
  EXPECT_NE(two[0], two[1]);
}

}  // namespace tenon::context_test
