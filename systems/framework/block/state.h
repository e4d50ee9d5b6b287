#pragma once

#include <tenon/systems/framework/block/ports.h>
#include <tenon/systems/framework/block/random_stream.h>

#include <algorithm>
#include <functional>

namespace tenon {

/// A state that is integrated. `T` is double, Vec<N>, a struct of those with Fields(), or Eigen::VectorXd,
/// which keeps the size of its initial value. All continuous states of a diagram form one contiguous vector,
/// in the order of the blocks.
template <class T>
class ContinuousState : public Source {
  static_assert((alignof(T) <= alignof(double) && internal::kBitwise<T>) ||
                    std::is_same_v<T, Eigen::VectorXd>,
                "A continuous state is made of plain doubles: use double, Vec<N>, a struct of them, or "
                "Eigen::VectorXd.");

 public:
  using Value = T;
  using Argument = const T&;
  ContinuousState(Leaf* owner, Spec spec, T initial = internal::Zeroed<T>())
      : Source(owner, SourceKind::kContinuous, std::move(spec), internal::TypeInfoOf<T>(), &initial_),
        initial_(std::move(initial)) {}

 private:
  T initial_;
};

/// The time derivative of a continuous state; every continuous state has exactly one.
template <class T>
class TimeDerivative : public Calculated<T> {
 public:
  using Calculated<T>::Calculated;
  using Value = T;
  template <class... A, class F>
  TimeDerivative(const ContinuousState<T>& state, UsesList<A...> uses, F function,
                 std::uint64_t tag = internal::TagOf<F>::value)
      : Calculated<T>(const_cast<System*>(&internal::CheckDeclared(state, "a TimeDerivative").owner()),
                      SourceKind::kDerivative,
                      Spec{"d/dt " + state.name(), state.spec().units, state.spec().elements}) {
    this->SetTarget(state);
    this->Calculate(std::move(uses), std::move(function), tag);
  }
  /// Uses the value of an input as the derivative.
  TimeDerivative(const ContinuousState<T>& state, const InputPort<T>& rate)
      : TimeDerivative(state, Uses(rate), [](const T& value) -> const T& { return value; }) {
    this->SetIsCopy();
  }
};

/// A state that changes only by Update. `T` is any copyable type.
template <class T>
class DiscreteState : public Source {
 public:
  using Value = T;
  using Argument = const T&;
  DiscreteState(Leaf* owner, Spec spec, T initial = internal::Zeroed<T>())
      : Source(owner, SourceKind::kDiscrete, std::move(spec), internal::TypeInfoOf<T>(), &initial_),
        initial_(std::move(initial)) {}

 private:
  T initial_;
};

/// A discrete state that is an enumeration.
template <class E>
requires std::is_enum_v<E>
using Mode = DiscreteState<E>;

enum class Crossing { kRising, kFalling, kBoth };

/// A function w(t, x, …) whose zero crossing is an event. Pass it to an Update or a Publish as its trigger.
///
/// A witness is on one side of zero; a crossing is the first instant at which it is zero or on the other
/// side. Crossings are located on the dense output, inside integrator steps, to the rounding of the time.
/// They are also detected after each tick, declared jump and update. After an event the witness starts from
/// its new value: if that is zero within rounding, the witness takes the side to which it then moves, and
/// neither leaving zero nor staying there is a crossing. The updates of one event take effect together and
/// once, also for `kBoth`.
///
/// Each step is sampled at five or more points, and more finely where these show that the witness curves
/// between them. Two crossings that are closer together and leave no trace at the sampled points are missed:
/// limit the step with SimulatorOptions::max_step.
///
/// A run ends with a RunError that names the witness if events accumulate (a ball that bounces ever faster),
/// if a witness fires more than SimulatorOptions::max_events times at one instant, or if its value is not a
/// number.
class Witness : public Calculated<double> {
 public:
  using Calculated<double>::Calculated;
  using Value = double;
  using Argument = const double&;
  template <class... A, class F>
  Witness(Leaf* owner, std::string name, Crossing crossing, UsesList<A...> uses, F function,
          std::uint64_t tag = internal::TagOf<F>::value)
      : Calculated<double>(owner, SourceKind::kWitness, Spec{std::move(name)}), crossing_(crossing) {
    Calculate(std::move(uses), std::move(function), tag);
  }
  Crossing crossing() const { return crossing_; }

 private:
  Crossing crossing_;
};

inline Trigger::Trigger(const Witness& crossed)
    : when(When::kWitness), witness(&internal::CheckDeclared(crossed, "a trigger")) {}

/// The index of the smooth piece on which the block's calculations are: -1 below a saturation, 0 inside it, 1
/// above; the segment of a table; the multiple of a quantizer. Where a derivative depends on this block, the
/// integrator ends its step where the index changes and restarts after it, so that no step spans a kink or a
/// jump. It costs as much as a Witness there, and nothing in a diagram without such a derivative.
///
///     Kink kink{this, "kink", Uses(u), [](double u) { return u < -1 ? -1 : u > 1 ? 1 : 0; }};
///
/// A state that slides along a discontinuity, because the derivatives of both pieces point towards it, ends
/// the run with a RunError that names the kink: give the block a Mode for the sliding motion.
class Kink : public Calculated<std::int64_t> {
 public:
  using Calculated<std::int64_t>::Calculated;
  using Value = std::int64_t;
  using Argument = const std::int64_t&;
  template <class... A, class F>
  Kink(Leaf* owner, std::string name, UsesList<A...> uses, F function,
       std::uint64_t tag = internal::TagOf<F>::value)
      : Calculated<std::int64_t>(owner, SourceKind::kKink, Spec{std::move(name)}) {
    Calculate(std::move(uses), std::move(function), tag);
  }
};

/// The next instant [s] after `time` at which the block's calculations jump or bend as functions of time;
/// infinity if there is none. Integrator steps end exactly there and restart, and evaluations before the
/// instant get a time before it. The function may use `time`, Parameters and discrete states.
///
///     NextJump next{this, "next", Uses(time), [](double t) { return t < 5 ? 5.0 : kNever; }};
///
/// A run throws RunError if the instant is not later than the time, or not a number.
class NextJump : public Calculated<double> {
 public:
  using Calculated<double>::Calculated;
  using Value = double;
  using Argument = const double&;
  template <class... A, class F>
  NextJump(Leaf* owner, std::string name, UsesList<A...> uses, F function,
           std::uint64_t tag = internal::TagOf<F>::value)
      : Calculated<double>(owner, SourceKind::kNextJump, Spec{std::move(name), "s"}) {
    Calculate(std::move(uses), std::move(function), tag);
  }
};

/// The value of a NextJump if no jump is left [s].
inline constexpr double kNever = std::numeric_limits<double>::infinity();

/// The first of increasing `instants` [s] that is later than `time`, for a NextJump; kNever if none is.
inline double NextOf(const std::vector<double>& instants, double time) {
  const auto next = std::upper_bound(instants.begin(), instants.end(), time);
  return next == instants.end() ? kNever : *next;
}

/// Instants at which a function jumps, for DiagramBuilder::AddFunction: an increasing list, or a rule that
/// returns the first instant later than a given time.
struct JumpsAt {
  std::vector<double> instants = {};             ///< [s]
  std::function<double(double time)> rule = {};  ///< takes precedence over `instants`
  double Next(double time) const { return rule ? rule(time) : NextOf(instants, time); }
};

/// The next value of a discrete or continuous state when its trigger fires. All updates of one instant read
/// the old values, then take effect together.
template <class T>
class Update : public Calculated<T> {
 public:
  using Calculated<T>::Calculated;
  using Value = T;
  template <class State, class... A, class F>
  Update(const State& state, Trigger trigger, UsesList<A...> uses, F function,
         std::uint64_t tag = internal::TagOf<F>::value)
      : Calculated<T>(const_cast<System*>(&internal::CheckDeclared(state, "an Update").owner()),
                      SourceKind::kUpdate,
                      Spec{"next " + state.name(), state.spec().units, state.spec().elements}) {
    static_assert(std::is_same_v<typename State::Value, T>, "An Update has the type of its state.");
    this->SetTarget(state);
    this->SetTrigger(trigger);
    this->Calculate(std::move(uses), std::move(function), tag);
  }
};

/// A value that several calculations of a block use (kinematics, say), computed once per evaluation. It keeps
/// nothing from one evaluation to the next. In-place functions fill a copy of `model`.
///
/// If the function is an object with operator==, shared values of several blocks that are equal functions of
/// the same sources are computed once for all of them.
template <class T>
class Shared : public Calculated<T> {
 public:
  using Calculated<T>::Calculated;
  using Value = T;
  using Argument = const T&;
  template <class... A, class F>
  Shared(Leaf* owner, std::string name, UsesList<A...> uses, F function,
         std::uint64_t tag = internal::TagOf<F>::value)
      : Calculated<T>(owner, SourceKind::kShared, Spec{std::move(name)}) {
    this->Calculate(std::move(uses), std::move(function), tag);
    if constexpr (std::is_class_v<F> && std::equality_comparable<F>) this->template SetComparison<F>();
  }
  template <class... A, class F>
  Shared(Leaf* owner, std::string name, T model, UsesList<A...> uses, F function,
         std::uint64_t tag = internal::TagOf<F>::value)
      : Shared(owner, std::move(name), std::move(uses), std::move(function), tag) {
    this->model_ = std::move(model);
  }
};

/// Memory that one calculation keeps from call to call and that is part of the run, such as a warm start. It
/// is saved and cloned with the context. The function receives it by reference.
template <class T>
class Scratch : public Source {
 public:
  using Value = T;
  using Argument = T&;
  Scratch(Leaf* owner, std::string name, T initial = internal::Zeroed<T>())
      : Source(owner, SourceKind::kScratch, Spec{std::move(name)}, internal::TypeInfoOf<T>(), &initial_),
        initial_(std::move(initial)) {}

 private:
  T initial_;
};

/// Memory that one calculation needs but that carries no information from call to call, such as a solver's
/// workspace. Every context gets its own copy of `model`.
template <class T>
class Workspace : public Source {
 public:
  using Value = T;
  using Argument = T&;
  Workspace(Leaf* owner, std::string name, T model = T())
      : Source(owner, SourceKind::kWorkspace, Spec{std::move(name)}, internal::TypeInfoOf<T>(), &model_),
        model_(std::move(model)) {}

 private:
  T model_;
};

/// The block's own stream of random numbers, seeded by the run's seed and the block's path. Only sampled
/// outputs and updates may use it, because all other calculations are evaluated as often as the integrator
/// needs.
class Random : public Source {
 public:
  using Value = RandomStream;
  using Argument = RandomStream&;
  Random(Leaf* owner, std::string name)
      : Source(owner, SourceKind::kRandom, Spec{std::move(name)}, internal::TypeInfoOf<RandomStream>(),
               &initial_) {}

 private:
  RandomStream initial_;
};

/// The result of a Monitor: empty, or the reason to end the run.
using Verdict = std::optional<std::string>;

/// A termination condition, evaluated at its sample times or after every step.
class Monitor : public Calculated<Verdict> {
 public:
  using Calculated<Verdict>::Calculated;
  using Value = Verdict;
  template <class When, class... A, class F>
  requires(std::is_same_v<When, Sampled> || std::is_same_v<When, EachStep>)
      Monitor(Leaf* owner, std::string name, When when, UsesList<A...> uses, F function,
              std::uint64_t tag = internal::TagOf<F>::value)
      : Calculated<Verdict>(owner, SourceKind::kMonitor, Spec{std::move(name)}) {
    SetTrigger(when);
    Calculate(std::move(uses), std::move(function), tag);
  }
};

}  // namespace tenon
