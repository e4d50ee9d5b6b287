#pragma once

#include <tenon/systems/framework/block/ports.h>
#include <tenon/systems/framework/block/random_stream.h>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace tenon {

/// A state that is integrated. `T` is double, Vec<N>, or a struct of those with Fields(); or Eigen::VectorXd,
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
  /// The value of an input, as it is.
  TimeDerivative(const ContinuousState<T>& state, const InputPort<T>& rate)
      : TimeDerivative(state, Uses(rate), [](const T& rate) -> const T& { return rate; }) {
    this->SetIsCopy();
  }
};

/// A state that changes only by Update. Any copyable type.
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

/// A discrete state with few values, by name: an enumeration.
template <class E>
requires std::is_enum_v<E>
using Mode = DiscreteState<E>;

enum class Crossing { kRising, kFalling, kBoth };

/// A function w(t, x, …) whose zero crossing is an event; give it to an Update as trigger.
///
/// A witness is on one side of zero, and a crossing is the first instant at which it is on zero or beyond.
/// Crossings are located inside the integrator's steps to the rounding of the time, on its dense output, and
/// looked for after each tick, declared jump and update. An event makes the witness start anew from where the
/// update sent it: if that is within rounding of zero, the witness takes the side to which it leaves, and
/// neither leaving zero nor resting on it is a crossing. The updates of one event take effect together, once,
/// for `kBoth` too.
///
/// Each step is looked at in at least five places, and in more where those show that the witness bends in
/// between. Two crossings that lie closer together than that, and leave no trace there, are missed: bound the
/// step with SimulatorOptions::max_step.
///
/// Events that accumulate (a ball that bounces ever faster) end the run with a RunError that names the
/// witness; so does a witness that fires more than SimulatorOptions::max_events times at one instant, or that
/// is not a number.
class Witness : public Calculated<double> {
 public:
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

inline Trigger::Trigger(const Witness& witness)
    : when(When::kWitness), witness(&internal::CheckDeclared(witness, "a trigger")) {}

/// The number of the smooth piece on which the block's calculations are: -1 below a saturation, 0 inside it,
/// 1 above; the segment of a table; the multiple of a quantizer. Where a derivative depends on this block,
/// the integrator ends a step where the number changes and starts again behind it, so that no step spans a
/// kink or a jump. Costs as much as a Witness there, and nothing in a diagram without such a derivative.
///
///     Kink kink{this, "kink", Uses(u), [](double u) { return u < -1 ? -1 : u > 1 ? 1 : 0; }};
///
/// A state that slides along a discontinuity, because both pieces send it back to the other, ends the run
/// with a RunError that names the kink: give the block a Mode for the sliding motion.
class Kink : public Calculated<std::int64_t> {
 public:
  using Value = std::int64_t;
  using Argument = const std::int64_t&;
  template <class... A, class F>
  Kink(Leaf* owner, std::string name, UsesList<A...> uses, F function,
       std::uint64_t tag = internal::TagOf<F>::value)
      : Calculated<std::int64_t>(owner, SourceKind::kKink, Spec{std::move(name)}) {
    Calculate(std::move(uses), std::move(function), tag);
  }
};

/// The next instant [s], later than `time`, at which the block's calculations jump or bend in time; infinity
/// if there is none. Steps of the integrator end exactly there and start again, and what is evaluated before
/// the instant gets a time before it. The function may use `time`, Parameters and discrete states.
///
///     NextJump next{this, "next", Uses(time), [](double t) { return t < 5 ? 5.0 : kNever; }};
///
/// Throws RunError, in a run, if the instant is not later than the time, or not a number.
class NextJump : public Calculated<double> {
 public:
  using Value = double;
  using Argument = const double&;
  template <class... A, class F>
  NextJump(Leaf* owner, std::string name, UsesList<A...> uses, F function,
           std::uint64_t tag = internal::TagOf<F>::value)
      : Calculated<double>(owner, SourceKind::kNextJump, Spec{std::move(name), "s"}) {
    Calculate(std::move(uses), std::move(function), tag);
  }
};

/// A NextJump's answer if no jump is left.
inline constexpr double kNever = std::numeric_limits<double>::infinity();

/// The first of increasing `instants` [s] that is later than `time`, for a NextJump; kNever if none is.
inline double NextOf(const std::vector<double>& instants, double time) {
  const auto next = std::upper_bound(instants.begin(), instants.end(), time);
  return next == instants.end() ? kNever : *next;
}

/// Instants at which a function jumps, for DiagramBuilder::AddFunction: increasing, or a rule for the next
/// one that is later than a time.
struct JumpsAt {
  std::vector<double> instants = {};             ///< [s]
  std::function<double(double time)> rule = {};  ///< used if there is one
  double Next(double time) const { return rule ? rule(time) : NextOf(instants, time); }
};

/// The next value of a state, discrete or continuous, when its trigger fires. All updates of one instant read
/// the old values, then take effect together.
template <class T>
class Update : public Calculated<T> {
 public:
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

/// A value that several calculations of a block use (kinematics, say), computed once per evaluation. It
/// carries nothing from one evaluation to the next. `model` gives the object that in-place functions fill.
template <class T>
class Shared : public Calculated<T> {
 public:
  using Value = T;
  using Argument = const T&;
  template <class... A, class F>
  Shared(Leaf* owner, std::string name, UsesList<A...> uses, F function,
         std::uint64_t tag = internal::TagOf<F>::value)
      : Calculated<T>(owner, SourceKind::kShared, Spec{std::move(name)}) {
    this->Calculate(std::move(uses), std::move(function), tag);
  }
  template <class... A, class F>
  Shared(Leaf* owner, std::string name, T model, UsesList<A...> uses, F function,
         std::uint64_t tag = internal::TagOf<F>::value)
      : Shared(owner, std::move(name), std::move(uses), std::move(function), tag) {
    this->model_ = std::move(model);
  }
};

/// Memory that one calculation keeps from call to call and that belongs to the run: a warm start, say. It is
/// saved and cloned with the context. The function receives it by reference.
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

/// Memory that one calculation needs but that holds nothing of the run: a solver's work space. Every context
/// gets its own copy of `model`.
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
/// outputs and updates may use it: anything else is evaluated as often as the integrator pleases.
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

/// What a Monitor says: nothing, or the reason for which the run ends here.
using Verdict = std::optional<std::string>;

/// A check that can end a run with a reason, at its sample times or after every step.
class Monitor : public Calculated<Verdict> {
 public:
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
