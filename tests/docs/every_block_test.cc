// Properties that every block of the catalogue has with the shipped parameters. A new block is tested as soon
// as it is in docs/catalogue/catalogue.cc.

#include <tenon/controllers/cdpr/equilibrium_path.h>
#include <tenon/docs/catalogue/documents.h>
#include <tenon/docs/catalogue/headers.h>
#include <tenon/docs/catalogue/scenario_page.h>
#include <tenon/plants/signals/cdpr_signals.h>
#include <tenon/plants/signals/legged_signals.h>
#include <tenon/tests/testing/block_test.h>
#include <tenon/tests/testing/temporary_path.h>

#include <set>

namespace tenon::docs::every_block_test {

/// Visits the numbers of parameters in the order of their ranges, and changes one of them.
class Setter final : public internal::ValueVisitor {
 public:
  using Change = std::function<double(double)>;
  Setter(std::size_t index, Change change) : index_(index), change_(std::move(change)) {}
  void Numbers(void* data, internal::ScalarKind kind, std::size_t rows, std::size_t cols) override {
    internal::WithKind(kind, data, [&](auto* numbers) {
      using Number = std::remove_reference_t<decltype(*numbers)>;
      for (std::size_t i = 0; i < rows * cols; ++i, ++at_) {
        if (at_ != index_) continue;
        const double value = change_(static_cast<double>(numbers[i]));
        const auto changed = static_cast<Number>(value);
        set = static_cast<double>(changed) == value || std::isnan(static_cast<double>(changed));
        if (set) numbers[i] = changed;
      }
    });
  }
  bool set = false;  ///< false if the type cannot hold the value, as an integer a fraction

 private:
  std::size_t index_, at_ = 0;
  Change change_;
};

/// Numbers that a range does not contain: at and beyond its ends, and those that are not finite.
std::vector<double> Outside(const Range& range) {
  std::vector<double> values;
  if (range.any()) return values;
  const double low = range.low(), high = range.high();
  for (const double value :
       {test::kNan, -test::kInfinity, test::kInfinity, low - 1, low, std::nextafter(low, -test::kInfinity),
        high + 1, high, std::nextafter(high, test::kInfinity)})
    if (!range.Contains(value)) values.push_back(value);
  return values;
}

/// Calls `test` with each block, and names the block in all failures.
template <class Test>
void ForEveryBlock(const Test& test) {
  static const std::vector<Shelf> kShelves = MakeCatalogue();
  for (const Shelf& shelf : kShelves) {
    for (const Entry& entry : shelf.entries) {
      SCOPED_TRACE(entry.title);
      EXPECT_NO_THROW(test(entry));
    }
  }
}

TEST(EveryBlock, RefusesParametersOutsideOfTheirRanges) {
  int refused = 0;
  ForEveryBlock([&](const Entry& entry) {
    for (const Field& field : entry.ranges) {
      if (field.type == nullptr) continue;
      const auto member = [&](void* params) { return static_cast<std::byte*>(params) + field.offset; };
      std::vector<Range> ranges;
      entry.build([&](void* params) {
        ranges = internal::ListRanges({field.name, field.units, &field.range, &field.type()}, member(params));
      });
      for (std::size_t i = 0; i < ranges.size(); ++i) {
        for (const double value : Outside(ranges[i])) {
          Setter setter(i, [&](double) { return value; });
          const auto make = [&] {
            entry.build([&](void* params) { internal::Walk(field.type(), member(params), setter); });
          };
          const auto result = Throws<ParameterError>(make, field.name);
          EXPECT_TRUE(result || !setter.set) << result.message() << ": " << field.name << " = " << value;
          refused += setter.set ? 1 : 0;
        }
      }
    }
  });
  EXPECT_GT(refused, 150);
}

/// A block alone, whose inputs have their initial values with small changes that differ from number to
/// number.
class Alone {
 public:
  explicit Alone(const Entry& entry, const std::function<void(void* params)>& change = {})
      : diagram_(entry.build(change)), simulator_(diagram_->CreateContext(7), kOptions) {
    for (const Source* input : diagram_->open_inputs()) {
      context().SetDoubles(*input, input->initial_numbers());
      GiveCables(*input, entry.size);
      Give<Eigen::VectorXd>(*input, Eigen::VectorXd::Ones(entry.size));
      Give<LeggedState>(*input, {.p_WB = {0, 0, 0.5}});  // monitors would end the run on the floor
      Give<PlatformState>(*input, {.p_WB = {0, 0, 2}});
    }
    Disturb(1);
  }
  /// Returns whether the input is that of signals of cables, which it then has for `n` cables.
  bool GiveCables(const Source& input, int n) {
    const CableVector some = CableVector::Constant(n, 50);
    return Give<CableVector>(input, some) || Give<CableSignals>(input, {some, some, some, some}) ||
           Give<CdprReference>(input, {.length = some, .length_rate = some, .tension = some});
  }
  void Disturb(std::uint64_t seed, double most = 0.01) {
    RandomStream random(seed);
    for (const Source* input : diagram_->open_inputs()) {
      std::vector<double> numbers = context().EvalDoubles(*input);
      for (double& number : numbers) number += most * random.Uniform(-1, 1);
      try {
        context().SetDoubles(*input, numbers);
      } catch (const ParameterError&) {  // it has whole numbers
      }
    }
  }
  /// Outputs and states in a run whose inputs jump ever further.
  std::vector<double> Run() {
    std::vector<double> all;
    for (int n = 1; n <= 5; ++n) {
      for (const auto& [name, values] : ValuesAt(0.04 * n, context().Clone()))
        all.insert(all.end(), values.begin(), values.end());
      RunTo(0.03 * n);
      Disturb(n, 0.1 * n * n);
    }
    return all;
  }
  void RunTo(double time) { static_cast<void>(simulator_.AdvanceTo(time)); }
  Context& context() { return simulator_.context(); }
  const Diagram& diagram() const { return *diagram_; }

  /// Outputs and states at `time` of a run that continues from `context`.
  static std::map<std::string, std::vector<double>> ValuesAt(double time, std::unique_ptr<Context> context) {
    Simulator copy(std::move(context), kOptions);
    static_cast<void>(copy.AdvanceTo(time));
    std::map<std::string, std::vector<double>> values;
    for (const Source* source : copy.context().diagram().FindBlock("block").sources()) {
      const SourceKind kind = source->kind();
      if (kind != SourceKind::kOutput && kind != SourceKind::kContinuous && kind != SourceKind::kDiscrete)
        continue;
      std::vector<double>& numbers = values[source->name()] = copy.context().EvalDoubles(*source);
      // Wall-clock times, which no block depends on.
      const std::vector<Element> elements = copy.context().Elements(*source);
      for (std::size_t i = 0; i < elements.size(); ++i)
        if (elements[i].name.ends_with("solve_time")) numbers.at(i) = 0;
    }
    return values;
  }

 private:
  template <class T>
  bool Give(const Source& input, const T& value) {
    if (*input.type().id != typeid(T)) return false;
    context().Set(static_cast<const InputPort<T>&>(input), value);
    return true;
  }

  static constexpr SimulatorOptions kOptions{.publish = false};
  std::shared_ptr<const Diagram> diagram_;
  Simulator simulator_;
};

bool IsDiagram(const Diagram& around) {
  return dynamic_cast<const Leaf*>(&around.FindBlock("block")) == nullptr;
}

// Whole loops stand for half a second and then walk.
TEST(EveryBlock, RunsWithoutAllocating) {
  ForEveryBlock([](const Entry& entry) {
    Alone alone(entry);
    alone.RunTo(0.1);
    alone.Disturb(2);
    alone.RunTo(0.15);
    const double end = alone.diagram().open_inputs().empty() ? 1.2 : 0.2;
    EXPECT_EQ(AllocationsOf([&] { alone.RunTo(end); }), 0);
  });
}

TEST(EveryBlock, RefusesSignalsOfAnotherNumberOfCables) {
  int refused = 0;
  ForEveryBlock([&](const Entry& entry) {
    for (std::size_t i = 0; i < Alone(entry).diagram().open_inputs().size(); ++i) {
      Alone alone(entry);
      const Source& input = *alone.diagram().open_inputs()[i];
      for (const int n : {entry.size - 1, 2 * entry.size}) {
        if (!alone.GiveCables(input, n)) continue;
        const auto run = [&] { Alone::ValuesAt(0.1, alone.context().Clone()); };
        EXPECT_TRUE(Throws<RunError>(run, "'block.")) << input.name() << " of " << n;
        ++refused;
      }
    }
  });
  EXPECT_GT(refused, 20);
}

TEST(EveryBlock, GoesOnBitForBitFromACloneAndASnapshot) {
  ForEveryBlock([](const Entry& entry) {
    Alone alone(entry);
    alone.RunTo(0.1);
    alone.Disturb(2);
    alone.RunTo(0.11);
    auto clone = alone.context().Clone(), restored = alone.diagram().CreateContext(8);
    restored->Restore(alone.context().Save());
    const auto wanted = Alone::ValuesAt(0.2, alone.context().Clone());
    alone.RunTo(0.13);  // changes what the block remembers outside of the context
    EXPECT_EQ(Alone::ValuesAt(0.2, std::move(clone)), wanted);
    EXPECT_EQ(Alone::ValuesAt(0.2, std::move(restored)), wanted);
  });
}

TEST(EveryBlock, RefusesParametersOutsideOfTheirRangesInARun) {
  int refused = 0;
  ForEveryBlock([&](const Entry& entry) {
    Alone alone(entry);
    alone.RunTo(0.1);
    Context& context = alone.context();
    for (const internal::ParameterSource* parameter : alone.diagram().parameters()) {
      const std::vector<double> numbers = context.EvalDoubles(*parameter);
      const std::vector<Range> ranges = parameter->ranges();
      EXPECT_EQ(parameter->elements().size(), numbers.size()) << parameter->path();
      context.SetDoubles(*parameter, numbers);
      for (std::size_t i = 0; i < ranges.size(); ++i) {
        for (const double value : Outside(ranges[i])) {
          std::vector<double> changed = numbers;
          changed.at(i) = value;
          EXPECT_TRUE(
              Throws<ParameterError>([&] { context.SetDoubles(*parameter, changed); }, parameter->name()))
              << value;
          ++refused;
        }
      }
      EXPECT_EQ(context.EvalDoubles(*parameter), numbers) << parameter->path();
    }
  });
  EXPECT_GT(refused, 3000);
}

TEST(EveryBlock, ActsOnASetParameterAsOnOneThatItIsMadeWith) {
  const std::array<Setter::Change, 4> changes{[](double x) { return 1.5 * x + 0.01; },
                                              [](double x) { return 0.7 * x; },
                                              [](double x) { return 1 - x; }, [](double x) { return x + 1; }};
  std::set<std::string> idle;
  ForEveryBlock([&](const Entry& entry) {
    const auto diagram = entry.build({});
    if (IsDiagram(*diagram)) return;  // its blocks have entries of their own
    const std::vector<double> before = Alone(entry).Run();
    for (std::size_t k = 0; k < diagram->parameters().size(); ++k) {
      const internal::ParameterSource& parameter = *diagram->parameters()[k];
      const std::size_t offset = parameter.offset_in_params();
      if (offset == parameter.kNone) continue;
      bool acts = false;
      for (std::size_t i = 0; i < parameter.initial_numbers().size(); ++i) {
        for (const Setter::Change& change : changes) {
          Setter setter(i, change);
          std::optional<Alone> given;
          Alone set(entry);
          try {
            given.emplace(entry, [&](void* params) {
              internal::Walk(parameter.type(), static_cast<std::byte*>(params) + offset, setter);
            });
            set.context().SetDoubles(*set.diagram().parameters()[k],
                                     given->diagram().parameters()[k]->initial_numbers());
          } catch (const ParameterError&) {  // out of range
            continue;
          }
          if (!setter.set) continue;
          const std::vector<double> wanted = given->Run();
          EXPECT_EQ(set.Run(), wanted) << parameter.name() << ", number " << i;
          acts = acts || wanted != before;
          if (wanted != before) break;
        }
      }
      if (!acts) idle.insert(entry.name + "." + parameter.name());
    }
  });
  // Parameters that need other inputs or a longer run, which the tests of their blocks have.
  EXPECT_EQ(idle, (std::set<std::string>{"CdprMonitor.floor",
                                         "CdprMonitor.forbid_slack",
                                         "CdprMonitor.max_tension_ratio",
                                         "CdprMpc.max_fallbacks_in_a_row",
                                         "CdprMpc.terminal_weights",
                                         "ComPlanner.zmp",
                                         "DiscreteStateSpace.D",
                                         "FallMonitor.max_height",
                                         "FallMonitor.max_tilt",
                                         "FallMonitor.min_height",
                                         "FootScheduler.early_touchdown_phase",
                                         "FootScheduler.gaits",
                                         "FootScheduler.late_wait",
                                         "FootScheduler.start_margin",
                                         "FootScheduler.touchdown_force",
                                         "GroundForceObserver.thresholds",
                                         "LeggedStateEstimator.settle_time",
                                         "ObstacleDetector.half_width",
                                         "ObstacleDetector.range",
                                         "PayloadSchedule.attach",
                                         "PayloadSchedule.load",
                                         "PayloadSchedule.release",
                                         "PulseForce.duration",
                                         "PulseForce.push",
                                         "PulseForce.start",
                                         "RandomForce.lower",
                                         "RateLimiter.falling",
                                         "RateLimiter.rising",
                                         "SignalFault.size",
                                         "SineForce.angular_frequency",
                                         "SineForce.end",
                                         "SineForce.start",
                                         "Slow.max_fallbacks_in_a_row",
                                         "Slow.terminal_weights",
                                         "StateSpace.D",
                                         "SwingPlanner.step",
                                         "ThesisPlanner.zmp",
                                         "TrackingError.min_singular_value",
                                         "TrunkPlanner.bandwidth",
                                         "TrunkPlanner.sway_limit",
                                         "WalkDrive.gait",
                                         "WholeBodyController.max_failures_in_a_row"}));
}

// The generated pages of docs/ are up to date.
namespace fs = std::filesystem;

const fs::path kSource = TENON_SOURCE_DIR;
constexpr const char* kRenew = "; renew it by tools/docs --blocks";

std::vector<std::string> ReadLines(std::istream&& in) {
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

TEST(BlocksTest, EveryBlockOfThePublicHeadersIsInTheCatalogue) {
  std::set<std::string> known;
  for (const Shelf& shelf : MakeCatalogue()) {
    for (const Entry& entry : shelf.entries) known.insert(entry.name);
  }
  int blocks = 0;
  for (const auto& [name, declaration] : ReadHeaders(kSource)) {
    if (!declaration.is_block) continue;
    ++blocks;
    EXPECT_TRUE(known.contains(name))
        << declaration.header << " declares " << name << ": put it into docs/catalogue/catalogue.cc";
  }
  EXPECT_EQ(blocks, known.size());
}

TEST(BlocksTest, HeadersHaveSummaries) {
  const auto declarations = ReadHeaders(kSource);
  EXPECT_EQ(declarations.at("Gain").header, "systems/primitives/gain.h");
  const std::string plant = declarations.at("QuadrupedPlant").summary;  // one sentence on two lines
  EXPECT_THAT(plant, testing::AllOf(HasSubstrs("quadruped_body.h", "foot_contact.h"), testing::EndsWith("."),
                                    testing::Not(testing::HasSubstr("\n"))));
  EXPECT_FALSE(declarations.at("LeggedState").is_block);
  for (const auto& [name, declaration] : declarations) {
    EXPECT_TRUE(!declaration.is_block || !declaration.summary.empty()) << name;
  }
}

TEST(BlocksTest, ParametersHaveDescriptionsAndUnits) {
  // Ratios, counts and flags, and a gain whose unit depends on its use.
  const std::set<std::string> no_unit{"early_touchdown_phase",
                                      "friction",
                                      "outlier",
                                      "max_failures_in_a_row",
                                      "max_fallbacks_in_a_row",
                                      "forbid_slack",
                                      "max_tension_ratio",
                                      "on_trunk",
                                      "active",
                                      "gait",
                                      "stands",
                                      "grip",
                                      "goal",
                                      "gain",
                                      "share"};
  int count = 0;
  for (const Shelf& shelf : MakeCatalogue()) {
    for (const Entry& entry : shelf.entries) {
      for (const Source* source : entry.block->sources()) {
        if (source->kind() != SourceKind::kParameter) continue;
        ++count;
        const std::string name = entry.title + "." + source->name();
        EXPECT_FALSE(static_cast<const internal::ParameterSource*>(source)->description().empty()) << name;
        // The units of a primitive are those of its signals.
        const bool generic =
            entry.title.find('<') != std::string::npos || entry.title.ends_with("StateSpace");
        if (generic || no_unit.contains(source->name())) continue;
        for (const Element& element : source->elements())
          EXPECT_TRUE(!element.unit.empty() || element.name.size() > 1) << name;
      }
    }
  }
  EXPECT_GT(count, 60);
}

/// Expects that a file of the source tree has the text that would be generated now.
void ExpectUpToDate(const char* file, const std::string& text) {
  const auto found = ReadLines(std::ifstream(kSource / file));
  const auto wanted = ReadLines(std::istringstream(text));
  const auto [ours, theirs] = std::mismatch(found.begin(), found.end(), wanted.begin(), wanted.end());
  EXPECT_TRUE(ours == found.end() && theirs == wanted.end())
      << file << ", line " << ours - found.begin() + 1 << ", is\n  "
      << (ours == found.end() ? "missing" : *ours) << "\nand should be\n  "
      << (theirs == wanted.end() ? "missing" : *theirs) << kRenew;
}

TEST(BlocksTest, ThePageIsUpToDate) {
  ExpectUpToDate("docs/blocks.md", WriteBlocks(kSource));
  EXPECT_THAT(WriteBlocks(kSource), testing::Not(testing::ContainsRegex("else *\\|"))) << "no default";
}

TEST(ScenarioPageTest, KeysAndMeaningsAreUpToDate) {
  ExpectUpToDate("docs/keys/meanings.yaml", WriteMeanings(kSource));
  ExpectUpToDate("docs/scenarios.md", WriteScenarioKeys());
}

TEST(ScenarioPageTest, DocstringsAreFoundWhereverTheyStand) {
  const fs::path source = test::TemporaryPath("docstrings");
  for (const char* directory : {"systems", "plants", "controllers", "diagrams", "apps"})
    fs::create_directories(source / directory);
  std::ofstream(source / "apps" / "path_scenario.h") << R"(
/// About the struct,
/// in two lines.
struct PathScenario {
  double ramp_s = 5;      ///< behind the member
  /// Above the member.
  double period_s = 10;
  double radius_m = 0.5;  ///< without its unit [m]

  static FieldList Fields() {
    return {{"ramp_s", &PathScenario::ramp_s},
            {"period_s", &PathScenario::period_s},
            {"radius_m", &PathScenario::radius_m}};
  }
};
)";
  const std::string meanings = WriteMeanings(source);
  for (const char* line :
       {"  PathScenario:\n", "    ramp_s: \"behind the member\"\n", "    period_s: \"Above the member.\"\n",
        "    radius_m: \"without its unit\"\n", "    about: \"About the struct, in two lines.\"\n"})
    EXPECT_NE(meanings.find(line), meanings.npos) << line << meanings;
  fs::remove_all(source);
}

TEST(ScenarioPageTest, EveryKeyHasADocstring) {
  std::istringstream page(WriteScenarioKeys());
  int keys = 0;
  for (std::string line; std::getline(page, line);) {
    if (!line.starts_with("| `")) continue;
    ++keys;
    EXPECT_FALSE(line.ends_with("|  |")) << line << " needs a docstring at its member" << kRenew;
  }
  EXPECT_GT(keys, 300);
}

TEST(BlocksTest, ThePicturesAreUpToDate) {
  for (const Picture& picture : MakePictures()) {
    EXPECT_TRUE(IsUpToDate(picture, kSource / "docs/diagrams"))
        << "docs/diagrams/" << picture.name << ".svg shows the diagram as it was" << kRenew;
  }
}

}  // namespace tenon::docs::every_block_test
