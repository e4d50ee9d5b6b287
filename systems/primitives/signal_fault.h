#pragma once

#include <tenon/systems/primitives/fault_schedule.h>

namespace tenon {

namespace internal {

/// Returns the indices, in order, of a signal's elements named in `names`: by their names in logs, or by the
/// beginning of a name up to a dot ("q" for "q.0", "q.1", …). No name means all elements. With `real_only`,
/// elements that are a bool, an integer or an enumeration are omitted, and rejected if named. Throws
/// ParameterError if a name matches no element, or none remains.
std::vector<std::size_t> FindElements(const std::vector<Element>& elements,
                                      const std::vector<std::string>& names, bool real_only);

/// Throws RunError if a signal does not have the number of elements that its fault expects.
void CheckCount(std::size_t found, std::size_t expected);

/// Copies all numbers of `value` into memory of that size.
template <class T>
void CopyElements(const T& value, std::vector<double>& numbers) {
  CheckCount(CountScalars(TypeInfoOf<T>(), &value), numbers.size());
  ToDoubles(TypeInfoOf<T>(), &value, numbers.data());
}

/// Calls `change(number, i)` for the chosen numbers of `value`; `numbers` is memory of the same size.
template <class T, class Change>
void ChangeElements(T& value, const std::vector<std::size_t>& chosen, std::vector<double>& numbers,
                    Change change) {
  CopyElements(value, numbers);
  for (const std::size_t i : chosen) change(numbers[i], i);
  FromDoubles(TypeInfoOf<T>(), &value, numbers.data());
}

}  // namespace internal

/// The output of a SignalFault while the fault acts, from its first tick on.
enum class SignalFaultKind {
  kDropOut,  ///< 0; the run ends with an error if u contains an enumeration without a 0
  kStuck,    ///< u at the last tick before the fault
  kNan,      ///< NaN; the run ends with an error that names the block
  kSpike,    ///< u + size at the first tick and every `period`, u at other ticks
  kOffset,   ///< u + size
  kLoss,     ///< (1 - size) u
  kLate,     ///< u from `samples` ticks ago
  kLost,     ///< with `probability`, drawn at each tick, y of the tick before, else u
};

template <class T = double>
struct SignalFaultParams {
  SignalFaultKind kind = SignalFaultKind::kDropOut;
  FaultSchedule schedule = {};             ///< default: the whole run
  std::vector<std::string> affected = {};  ///< names of elements or their beginnings; empty for all
  double size = 0;                         ///< size of spike, offset [unit]; for loss the lost fraction of u
  double period = 0;                       ///< period of a spike [s], rounded to ticks; 0 for a single spike
  int samples = 1;                         ///< delay of late, in ticks, at least 1
  double probability = 0.5;                ///< probability of lost, 0 to 1
  T initial = internal::Zeroed<T>();       ///< y before the first tick; also sets run-time sizes
  Rate rate = Hz(1000);
  std::string unit = "";      ///< unit of input and output
  std::string elements = "";  ///< names of the elements
  void Validate() const {
    Demand(std::isfinite(period) && (period == 0 || period > rate.period() / 2),
           "period = " + std::to_string(period) + " must be 0 or at least the sample period, in seconds");
    Demand(samples >= 1 && samples <= 1'000'000,
           "samples = " + std::to_string(samples) + " must be from 1 to 1,000,000");
    Demand(probability >= 0 && probability <= 1,
           "probability = " + std::to_string(probability) + " must be from 0 to 1");
  }
};

/// A fault of a sensor, an actuator command or a connection: y = u, except that while the fault acts, the
/// affected elements of y are those of its kind (see SignalFaultKind).
///
///     builder.Insert(loop.world.inertial, fault.u, fault.y);
///
/// The fault acts while t is within `schedule` and `active` is true. With the default schedule a connected
/// `active` controls it alone.
///
/// T is any copyable type, though nan, spike, offset and loss change only real numbers. If only some elements
/// are affected, integers are exact up to 2^53. Feedthrough at its ticks, without delay. Does not allocate
/// during a run if T does not. Throws ParameterError for invalid numbers and unknown elements, and RunError
/// if the size of u differs from that of `initial`.
template <class T = double>
class SignalFault final : public LeafSystem<SignalFaultParams<T>> {
  using Kind = SignalFaultKind;

 public:
  struct Held {  // avoids std::vector<bool>, whose items have no addresses
    T value = internal::Zeroed<T>();
    static FieldList Fields() { return {{"value", &Held::value}}; }
  };
  /// Past values of u or y in a ring with the oldest at `next`, and the ticks since the fault began.
  struct Memory {
    std::vector<Held> values;
    int next = 0, ticks = -1;
    bool started = false;
    static FieldList Fields() {
      return {{"values", &Memory::values},
              {"next", &Memory::next},
              {"ticks", &Memory::ticks},
              {"started", &Memory::started}};
    }
  };

  using LeafSystem<SignalFaultParams<T>>::LeafSystem;
  using LeafSystem<SignalFaultParams<T>>::params;
  using LeafSystem<SignalFaultParams<T>>::time;

 private:
  const std::vector<std::size_t> chosen_ = FindChosen();  ///< empty if whole values are replaced
  const int spacing_ =
      std::max(1, static_cast<int>(std::lround(std::min(params.period / params.rate.period(), 1e9))));

 public:
  InputPort<T> u{this, {"u", params.unit, params.elements}};
  InputPort<bool> active{this, {"active"}, true};
  Parameter<double> size{this, {"size"}, params.size, "size of spike, offset and loss", Range().Finite()};
  Parameter<FaultSchedule> schedule{this, {"schedule"}, params.schedule, "times at which the fault acts"};
  Random random{this, "random"};
  Scratch<Memory> memory{
      this,
      "memory",
      {std::vector<Held>(params.kind == Kind::kLate ? static_cast<std::size_t>(params.samples) : 1,
                         Held{params.initial})}};
  Workspace<std::vector<double>> numbers{this, "numbers",
                                         internal::DoublesOf(internal::TypeInfoOf<T>(), &params.initial)};
  Workspace<std::vector<double>> held_numbers{
      this, "held_numbers", internal::DoublesOf(internal::TypeInfoOf<T>(), &params.initial)};
  OutputPort<bool> acting{this,
                          {"acting"},
                          Sampled{params.rate},
                          Uses(time, schedule, active),
                          [this](double time_now, const FaultSchedule& schedule_now, bool active_now) {
                            return active_now && schedule_now.Acts(time_now, params.rate);
                          }};
  OutputPort<T> y{this,
                  {"y", params.unit, params.elements},
                  params.initial,
                  Sampled{params.rate},
                  Uses(u, acting, size, random, memory, numbers, held_numbers),
                  &SignalFault::CalcY};

 private:
  bool changes_reals() const {
    return params.kind == Kind::kNan || params.kind == Kind::kSpike || params.kind == Kind::kOffset ||
           params.kind == Kind::kLoss;
  }
  std::vector<std::size_t> FindChosen() const {
    if (params.affected.empty() && !changes_reals() && params.kind != Kind::kDropOut) return {};
    return internal::FindElements(internal::ListElements(internal::TypeInfoOf<T>(), &params.initial,
                                                         Spec("y", params.unit, params.elements)),
                                  params.affected, changes_reals());
  }

  void CalcY(const T& u_now, bool acting_now, double size_now, RandomStream& stream, Memory& memory_now,
             std::vector<double>& numbers_now, std::vector<double>& held_numbers_now, T* y_out) const {
    if (!memory_now.started) std::fill(memory_now.values.begin(), memory_now.values.end(), Held{u_now});
    memory_now.started = true;
    memory_now.ticks = acting_now ? memory_now.ticks + 1 : -1;
    const bool lost = params.kind == Kind::kLost && stream.Uniform() < params.probability;
    T& held = memory_now.values[static_cast<std::size_t>(memory_now.next)].value;

    const auto change = [&](auto to) { internal::ChangeElements(*y_out, chosen_, numbers_now, to); };
    const auto hold = [&] {
      if (chosen_.empty()) {
        *y_out = held;
        return;
      }
      internal::CopyElements(held, held_numbers_now);
      change([&](double& x, std::size_t i) { x = held_numbers_now[i]; });
    };
    *y_out = u_now;
    if (acting_now) {
      switch (params.kind) {
        case Kind::kDropOut:
          change([](double& x, std::size_t) { x = 0; });
          break;
        case Kind::kNan:
          change([](double& x, std::size_t) { x = std::numeric_limits<double>::quiet_NaN(); });
          break;
        case Kind::kSpike:
          if (memory_now.ticks == 0 || (params.period > 0 && memory_now.ticks % spacing_ == 0))
            change([size_now](double& x, std::size_t) { x += size_now; });
          break;
        case Kind::kOffset:
          change([size_now](double& x, std::size_t) { x += size_now; });
          break;
        case Kind::kLoss:
          change([size_now](double& x, std::size_t) { x *= 1 - size_now; });
          break;
        case Kind::kLost:
          if (lost) hold();
          break;
        case Kind::kStuck:
        case Kind::kLate:
          hold();
      }
    }
    if (params.kind == Kind::kLate || (params.kind == Kind::kStuck && !acting_now)) held = u_now;
    if (params.kind == Kind::kLost) held = *y_out;
    if (++memory_now.next == static_cast<int>(memory_now.values.size())) memory_now.next = 0;
  }
};

}  // namespace tenon
