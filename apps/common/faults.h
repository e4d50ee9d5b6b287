#pragma once

#include <tenon/systems/framework/diagram/diagram_builder.h>
#include <tenon/systems/framework/types/fields.h>
#include <tenon/systems/primitives/signal_fault.h>

#include <array>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace tenon::apps {

/// Those of SignalFaultKind, by their names, and one that breaks things.
enum class FaultKind { kDropOut, kStuck, kNan, kSpike, kOffset, kLoss, kLate, kLost, kBroken };
constexpr auto EnumNames(FaultKind) {
  using enum FaultKind;
  return std::array{Named{kDropOut, "drop_out"}, Named{kStuck, "stuck"},   Named{kNan, "nan"},
                    Named{kSpike, "spike"},      Named{kOffset, "offset"}, Named{kLoss, "loss"},
                    Named{kLate, "late"},        Named{kLost, "lost"},     Named{kBroken, "broken"}};
}

/// A fault as scenarios say it, but for the place. What a kind does not need is refused, see SignalFault.
struct Fault {
  FaultKind kind = FaultKind::kDropOut;  ///< what goes wrong
  std::vector<std::string> elements =
      {};                             ///< of the signal, as logs name them, or joints, cables; empty: all
  double start_s = 0;                 ///< when it begins
  std::optional<double> duration_s;   ///< without: to the end of the run
  std::optional<double> size;         ///< of spike, offset [the signal's unit], and loss: 1 loses everything
  std::optional<double> period_s;     ///< of a spike; without: a single one
  std::optional<int> samples;         ///< of late: by how many ticks
  std::optional<double> probability;  ///< of lost, at each tick

  static FieldList Fields();
  void Validate() const;  ///< throws ParameterError

  FaultSchedule schedule() const {
    return {start_s, duration_s.value_or(std::numeric_limits<double>::infinity())};
  }
  /// The elements as indices of things of these names, each of which is `what`; throws ParameterError.
  std::vector<int> Indices(const char* what, const std::vector<Element>& things) const;
};

/// A fault at one of the places that a robot has.
template <NamedEnum Place>
struct FaultScenario : Fault {
  Place at{};  ///< which signal or part
  static FieldList Fields() {
    FieldList fields{Required("at", &FaultScenario::at)};
    for (const Field& field : Fault::Fields()) fields.push_back(field);
    return fields;
  }
};

/// Puts the faults of a scenario into a diagram, under the names fault_0, fault_1, ….
class FaultInserter {
 public:
  explicit FaultInserter(DiagramBuilder& builder) : builder(builder) {}
  DiagramBuilder& builder;
  std::vector<const Source*>
      signals;  ///< of all faults, for logs: whether they act, and the signals that they change

  /// Calls insert(fault, name) for each; throws KeyError for more than a robot may have. What it throws is
  /// told with the key of the fault, see KeyError.
  template <NamedEnum Place>
  void InsertAll(const std::vector<FaultScenario<Place>>& faults, const auto& insert) {
    CheckCount(faults.size());
    for (std::size_t i = 0; i < faults.size(); ++i)
      WithKey(i, EnumName(faults[i].at), [&] { insert(faults[i], "fault_" + std::to_string(i)); });
  }

 private:
  static void CheckCount(std::size_t count);
  static void WithKey(std::size_t index, const char* place, const std::function<void()>& insert);
};

/// The mechanical faults of one robot: each takes over what those before it say, the last one feeds the
/// plant.
template <class T>
class FaultChain {
 public:
  explicit FaultChain(InputPort<T>& plant) : plant_(&plant) {}
  /// `faults` and `others` are of one block.
  void Append(DiagramBuilder& builder, const OutputPort<T>& faults, InputPort<T>& others) {
    if (last_ != nullptr) {
      builder.Disconnect(*plant_);
      builder.Connect(*last_, others);
    }
    builder.Connect(faults, *plant_);
    last_ = &faults;
  }

 private:
  InputPort<T>* plant_;
  const OutputPort<T>* last_ = nullptr;
};

/// Throws ParameterError unless the kind is one of those that a mechanical part can have.
void DemandKind(const Fault& fault, const std::vector<FaultKind>& possible);
/// Throws ParameterError if a spike comes more often than the signal's samples.
void DemandPeriod(const Fault& fault, const Rate& rate);
/// The kind of the fault of a signal; throws ParameterError if it is none.
SignalFaultKind SignalKind(const Fault& fault);
/// Throws ParameterError: nothing in this diagram reads the signal.
[[noreturn]] void ThrowUnread(const char* remedy);

/// A place where a signal can fail: between an output and some of its readers. Without readers there is no
/// such place in the diagram.
template <class T>
class FaultPoint {
 public:
  /// `remedy` is what to do if nothing reads the signal.
  explicit FaultPoint(const char* remedy) : remedy_(remedy) {}
  FaultPoint(const OutputPort<T>& output, std::vector<InputPort<T>*> readers, Rate rate,
             T initial = internal::Zeroed<T>())
      : output_(&output), readers_(std::move(readers)), rate_(rate), initial_(initial) {}

  /// A fault behind those that are there already.
  void Insert(FaultInserter& inserter, const Fault& fault, const std::string& name) {
    if (output_ == nullptr) ThrowUnread(remedy_);
    DemandPeriod(fault, rate_);
    const SignalFaultParams<T> defaults;
    auto& block = inserter.builder.Add<SignalFault<T>>(
        name, {.kind = SignalKind(fault),
               .schedule = fault.schedule(),
               .affected = fault.elements,
               .size = fault.size.value_or(defaults.size),
               .period = fault.period_s.value_or(defaults.period),
               .samples = fault.samples.value_or(defaults.samples),
               .probability = fault.probability.value_or(defaults.probability),
               .initial = initial_,
               .rate = rate_,
               .unit = output_->spec().units,
               .elements = output_->spec().elements});
    inserter.builder.Connect(*output_, block.u);
    for (InputPort<T>* reader : readers_) {
      inserter.builder.Disconnect(*reader);
      inserter.builder.Connect(block.y, *reader);
    }
    output_ = &block.y;
    inserter.signals.insert(inserter.signals.end(), {&block.acting, &block.y});
  }

 private:
  const char* remedy_ = "";
  const OutputPort<T>* output_ = nullptr;
  std::vector<InputPort<T>*> readers_;
  Rate rate_ = Hz(1000);
  T initial_ = internal::Zeroed<T>();
};

}  // namespace tenon::apps
