#pragma once

#include <tenon/systems/framework/block/rate.h>
#include <tenon/systems/framework/types/signal.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace tenon {

class System;
class Diagram;
class Context;
class Source;

namespace internal {

class Assembly;
class Compiler;
struct Program;

/// What a block's calculations can use. Members of a class are made in the order of their declaration, so one
/// that is used above its declaration has an address but is no object yet: this is how to tell.
class Declared {
 public:
  Declared(const Declared&) = delete;
  Declared& operator=(const Declared&) = delete;
  static bool IsDeclared(const Declared& member);

 protected:
  Declared();
  ~Declared();
};

/// Empty if the source's block stands in its diagram; else which block took its place, and what to do.
std::string DescribeReplacement(const Source& source);

[[noreturn]] void ThrowUndeclared(const std::string& user, const std::string& used);

/// The same member; throws BuildError if it does not exist yet. `user` says what uses it.
template <class Member>
const Member& CheckDeclared(const Member& member, const char* user) {
  if (!Declared::IsDeclared(member)) ThrowUndeclared(user, "the state or event that it is for");
  return member;
}

/// Where a value lies in a context's memory.
using Offset = std::uint32_t;

/// What a calculation runs with: the block, and its function as it was written.
struct Closure {
  const System* self;
  const Source* calculation;
  void (*destroy)(Closure* closure);

  struct Delete {
    void operator()(Closure* closure) const { closure->destroy(closure); }
  };
};
template <class F>
struct ClosureOf : Closure {
  F function;
};

/// Runs `count` calculations of the same code, one after the other, each with its closure and its row: row[0]
/// says where the result goes, row[1 + i] where the i-th argument lies. For a list, that entry says how far
/// behind the row's beginning the list stands: its length, then where its values lie. The rows follow one
/// another. `current` is the index of the one that runs, for whoever catches what it throws. `carried` is the
/// argument that is, but for the first, the result of the calculation before, or kNoArgument.
using Thunk = void (*)(const Closure* const* closures, const Offset* rows, std::byte* memory,
                       std::size_t count, std::size_t* current, std::size_t carried);
inline constexpr std::size_t kNoArgument = static_cast<std::size_t>(-1);

/// One entry of a calculation's declared arguments.
struct Slot {
  enum class What {
    kSource,
    kTime,
    kList,  ///< the next `count` entries, one argument together
  };
  What what;
  const Source* source = nullptr;
  std::uint32_t count = 0;
};

}  // namespace internal

/// What a Source is; decides where its value is kept and when it is computed.
enum class SourceKind {
  kTime,
  kInput,       ///< an input port; its driver provides the value
  kOutput,      ///< an output port with a calculation, or with a driver (a state, an inner port)
  kContinuous,  ///< a continuous state
  kDerivative,  ///< the time derivative of a continuous state
  kDiscrete,    ///< a discrete state or mode
  kParameter,   ///< a value that stays unless somebody sets it
  kUpdate,      ///< the next value of a state, before it takes effect
  kShared,      ///< a value that several calculations of a block use
  kScratch,     ///< memory of one calculation, saved and cloned
  kWorkspace,   ///< memory of one calculation, made anew for every context
  kRandom,      ///< a stream of random numbers
  kWitness,     ///< a function whose zero crossing is an event
  kKink,        ///< the number of the smooth piece on which a block's calculations are
  kNextJump,    ///< the next instant at which a block's calculations jump
  kMonitor,     ///< a check that can end a run
  kPublish,     ///< a side effect
};

class Witness;

/// Trigger: after every accepted step of the integrator.
struct EachStep {};
/// Trigger: once, before the first tick of a run.
struct AtStart {};

/// When an Update or a Publish runs: give Sampled{rate}, EachStep{}, AtStart{} or a Witness in its place.
struct Trigger {
  enum class When { kAlways, kSampled, kEachStep, kAtStart, kWitness };
  Trigger() = default;
  Trigger(Sampled sampled) : when(When::kSampled), sampled(sampled) {}
  Trigger(EachStep) : when(When::kEachStep) {}
  Trigger(AtStart) : when(When::kAtStart) {}
  Trigger(const Witness& witness);

  When when = When::kAlways;
  Sampled sampled{Rate(1, 1)};
  const Witness* witness = nullptr;
};

/// A value inside a block: a port, a state, a shared value, a next value. Sources register with their block
/// and are never copied or moved. Users meet the typed classes derived from this one; this is what they
/// share.
class Source : public internal::Declared {
 public:
  SourceKind kind() const { return kind_; }
  const Spec& spec() const { return spec_; }
  const std::string& name() const { return spec_.name; }
  const System& owner() const { return *owner_; }
  /// "robot.pd.u": the path of the block, and the name.
  std::string path() const;
  /// The type of the value as one writes it: "LeggedState", "Vec<12>", "double".
  std::string type_name() const;
  /// The same, to look into.
  const internal::TypeInfo& type() const { return *type_; }
  /// Names and units of the elements of the value; sizes known at run time are those of the model value.
  std::vector<Element> elements() const;
  /// The elements before anything is computed: those of a state at the start, and those that an optional
  /// input has while nothing is connected to it.
  std::vector<double> initial_numbers() const;
  /// An input that has a default and need not be connected.
  bool is_optional() const { return kind_ == SourceKind::kInput && has_initial_value_; }
  const Trigger& trigger() const { return trigger_; }
  bool is_sampled() const { return trigger_.when == Trigger::When::kSampled; }
  /// What its calculation uses, but for the time.
  std::vector<const Source*> uses() const;
  /// Of a derivative or an update: the state that it belongs to; else null.
  const Source* target() const { return target_; }
  /// What this port is connected to, one hop up; null if nothing.
  const Source* driver() const { return driver_; }
  void AppendTo(std::vector<internal::Slot>& slots) const {
    slots.push_back({internal::Slot::What::kSource, this});
  }
  /// The same, unless its block, or a diagram around it, was replaced (see DiagramBuilder::Replace): then
  /// what has its path and type now. Figures and reports of a diagram that ships find what they need so.
  /// Throws BuildError that names what the new block lacks.
  const Source& Current() const;
  /// What provides this port's value: through connections up to a state, a calculation or an open input.
  const Source& Resolve() const;

 protected:
  Source(System* owner, SourceKind kind, Spec spec, const internal::TypeInfo& type, const void* model);
  ~Source() = default;

  template <class F>
  void SetCalculation(internal::Thunk run, F function, std::vector<internal::Slot> arguments) {
    run_ = run;
    const auto destroy = [](internal::Closure* closure) {
      delete static_cast<internal::ClosureOf<F>*>(closure);
    };
    closure_.reset(new internal::ClosureOf<F>{{owner_, this, destroy}, std::move(function)});
    arguments_ = std::move(arguments);
  }
  void SetDriver(const Source& driver) { driver_ = &driver; }
  void SetTarget(const Source& target) { target_ = &target; }
  void SetTrigger(Trigger trigger) { trigger_ = trigger; }
  void SetComesFromOutside() { comes_from_outside_ = true; }
  void SetIsCopy() { is_copy_ = true; }
  void SetHasInitialValue() { has_initial_value_ = true; }
  void CheckUses(int undeclared, bool merged) const;
  System* mutable_owner() const { return owner_; }

 private:
  friend class Context;
  friend class Diagram;
  friend class Reads;
  friend class Simulator;
  friend class SignalLog;
  friend class internal::Assembly;
  friend class internal::Compiler;
  friend struct internal::Program;

  System* owner_;
  SourceKind kind_;
  Spec spec_;
  const internal::TypeInfo* type_;
  const void* model_;  ///< lies in the derived class
  const Source* driver_ = nullptr;
  bool ignores_units_ = false;      ///< of the driver
  const Source* target_ = nullptr;  ///< of an update or a derivative: the state
  Trigger trigger_;
  bool comes_from_outside_ = false;  ///< an ExternalPort
  bool is_copy_ = false;             ///< of the one value that it uses
  bool has_initial_value_ = false;   ///< of a sampled output: readable before its first tick

  internal::Thunk run_ = nullptr;
  std::unique_ptr<internal::Closure, internal::Closure::Delete> closure_;
  std::vector<internal::Slot> arguments_;

  // Set when the diagram is built.
  internal::Offset offset_ = 0;
  int calculation_ = -1;  ///< index among the diagram's calculations
};

/// Source::Current with the type of the port.
template <class Port>
const Port& Current(const Port& port) {
  return static_cast<const Port&>(port.Current());
}

}  // namespace tenon
