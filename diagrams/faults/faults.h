#pragma once

#include <tenon/systems/framework/diagram/diagram_builder.h>
#include <tenon/systems/primitives/signal_fault.h>

namespace tenon {

/// The kinds of SignalFaultKind under the same names, and `broken` for mechanical parts.
enum class FaultKind { kDropOut, kStuck, kNan, kSpike, kOffset, kLoss, kLate, kLost, kBroken };

/// A fault of a signal or of a mechanical part, without its place. A number that the kind does not use must
/// not be given, see SignalFault.
struct Fault {
  FaultKind kind = FaultKind::kDropOut;    ///< type of the fault
  std::vector<std::string> elements = {};  ///< names of elements of the signal, joints or cables; empty: all
  double start_s = 0;                      ///< start time of the fault
  std::optional<double> duration_s;        ///< duration of the fault; empty: until the end of the run
  std::optional<double> size;      ///< size of spike and offset [unit of the signal], or of loss: 1 loses all
  std::optional<double> period_s;  ///< period of spikes; empty: a single spike
  std::optional<int> samples;      ///< delay of `late` in ticks
  std::optional<double> probability;  ///< probability of `lost` at each tick

  static FieldList Fields();
  void Validate() const;  ///< throws ParameterError

  FaultSchedule schedule() const {
    return {start_s, duration_s.value_or(std::numeric_limits<double>::infinity())};
  }
  /// Indices of `elements` in `parts`; `type` names a part in the message. Throws ParameterError for an
  /// unknown name.
  std::vector<int> Indices(const char* type, const std::vector<Element>& parts) const;
};

/// A fault at one of the places of a robot.
template <NamedEnum Place>
struct FaultAt : Fault {
  Place at{};  ///< signal or mechanical part at which the fault occurs
  static FieldList Fields() { return FieldList{Required("at", &FaultAt::at)} + Fault::Fields(); }
};

/// Error for a fault that is not possible in the diagram.
class FaultError : public ParameterError {
 public:
  FaultError(std::size_t index, const std::string& what) : ParameterError(what), index_(index) {}
  std::size_t index() const { return index_; }  ///< index of the fault in its list

 private:
  std::size_t index_;
};

/// Adds fault blocks to a diagram, under the names fault_0, fault_1, ….
class FaultInserter {
 public:
  explicit FaultInserter(DiagramBuilder& target) : builder(target) {}
  DiagramBuilder& builder;
  std::vector<const Source*> signals;  ///< `acting` of each fault, and the signal that it changes

  /// Calls insert(fault, name) for each fault. Throws FaultError for a fault that `insert` refuses, and
  /// ParameterError for more than 100 faults.
  template <NamedEnum Place>
  void InsertAll(const std::vector<FaultAt<Place>>& faults, const auto& insert) {
    CheckCount(faults.size());
    for (std::size_t i = 0; i < faults.size(); ++i)
      InsertOne(i, EnumName(faults[i].at), [&](const std::string& name) { insert(faults[i], name); });
  }

 private:
  static void CheckCount(std::size_t count);
  static void InsertOne(std::size_t index, const char* place,
                        const std::function<void(const std::string& name)>& insert);
};

/// Throws ParameterError unless the fault's kind is one of `possible`.
void DemandKind(const Fault& fault, const std::vector<FaultKind>& possible);

namespace internal {

/// Throws ParameterError if the period of a spike is shorter than the sample period.
void DemandPeriod(const Fault& fault, const Rate& rate);
/// Throws ParameterError if the fault's kind is for mechanical parts only.
SignalFaultKind SignalKind(const Fault& fault);
/// Remedy for a fault at a signal that no block reads.
inline constexpr const char* kReadIt = "connect it to an input of your block, or choose another place";
/// The rate at which a signal is sampled; 1 kHz for a continuous one.
Rate RateOf(const Source& signal);
/// Throws ParameterError because no block reads the signal, or the diagram has none (null); `hint` names the
/// remedy.
[[noreturn]] void ThrowUnread(const Source* signal, const char* hint);

}  // namespace internal

/// A place where a signal can fail: an output and all blocks that read it, except those that simulate or
/// judge the run. The output is that of the block that stands there, see DiagramBuilder::Replace.
template <class T>
class FaultPoint {
 public:
  /// Constructs a place that the diagram does not have: Insert throws an error with this hint.
  explicit FaultPoint(const char* hint) : hint_(hint) {}
  /// The fault is sampled like `clock`. `aside` are readers that it does not reach; `hint` names the remedy
  /// if it reaches none.
  FaultPoint(const OutputPort<T>& output, const Source& clock, const char* hint = internal::kReadIt,
             std::vector<const Source*> aside = {}, T initial = internal::Zeroed<T>())
      : hint_(hint), output_(&output), clock_(&clock), aside_(std::move(aside)), initial_(initial) {}

  /// Inserts a fault after the existing ones. Throws ParameterError, and BuildError if the block that
  /// replaced the output's block lacks it.
  void Insert(FaultInserter& inserter, const Fault& fault, const std::string& name) {
    if (output_ == nullptr) internal::ThrowUnread(nullptr, hint_);
    const OutputPort<T>& output = Current(*output_);
    const Rate rate = internal::RateOf(*clock_);
    internal::DemandPeriod(fault, rate);
    const SignalFaultParams<T> defaults;
    auto& block = inserter.builder.Add<SignalFault<T>>(
        name, {.kind = internal::SignalKind(fault),
               .schedule = fault.schedule(),
               .affected = fault.elements,
               .size = fault.size.value_or(defaults.size),
               .period = fault.period_s.value_or(defaults.period),
               .samples = fault.samples.value_or(defaults.samples),
               .probability = fault.probability.value_or(defaults.probability),
               .initial = initial_,
               .rate = rate,
               .unit = output.spec().units,
               .elements = output.spec().elements});
    try {
      inserter.builder.Insert(output, block.u, block.y, aside_);
    } catch (const BuildError&) {
      internal::ThrowUnread(&output, hint_);
    }
    output_ = &block.y;
    inserter.signals.insert(inserter.signals.end(), {&block.acting, &block.y});
  }

 private:
  const char* hint_;
  const OutputPort<T>* output_ = nullptr;
  const Source* clock_ = nullptr;
  std::vector<const Source*> aside_;
  T initial_ = internal::Zeroed<T>();
};

}  // namespace tenon
