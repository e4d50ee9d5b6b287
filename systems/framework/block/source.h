#pragma once

#include <tenon/systems/framework/block/rate.h>
#include <tenon/systems/framework/types/signal.h>

namespace tenon {

class System;
class Diagram;
class Context;
class Source;

namespace internal {

class Assembly;
class Compiler;
struct Program;

/// A member that calculations can use. Members of a class are constructed in the order of their declaration,
/// so a member that is used above its declaration has an address but is not yet an object; IsDeclared detects
/// that.
class Declared {
 public:
  Declared(const Declared&) = delete;
  Declared& operator=(const Declared&) = delete;
  static bool IsDeclared(const Declared& member);

 protected:
  Declared();
  ~Declared();
};

[[noreturn]] void ThrowUndeclared(const std::string& user, const std::string& used);

/// Returns `member`; throws BuildError if it does not exist yet. `user` names the user of the member.
template <class Member>
const Member& CheckDeclared(const Member& member, const char* user) {
  if (!Declared::IsDeclared(member)) ThrowUndeclared(user, "the state or event that it is for");
  return member;
}

/// Offset of a value in a context's memory [bytes].
using Offset = std::uint32_t;

/// The data of a calculation: its block and its function, and the declared size of its result if that is a
/// matrix of run-time size.
struct Closure {
  const System* self;
  const Source* calculation;
  void (*destroy)(Closure* closure);
  std::int32_t rows = -1, cols = -1;  ///< -1 if the size is not declared

  struct Delete {
    void operator()(Closure* closure) const { closure->destroy(closure); }
  };
};
template <class F>
struct ClosureOf : Closure {
  F function;
};

/// Runs `count` calculations of the same code in order, each with its closure and its row. row[0] is the
/// offset of the result, row[1 + i] the offset of argument i. For a list, row[1 + i] is the position of the
/// list relative to the beginning of the row: its length, then the offsets of its values. The rows are
/// contiguous. `current` is the index of the running calculation, for the handler of an exception. `carried`
/// is the index of the argument that, in all but the first calculation, is the previous result; kNoArgument
/// if there is none.
using Thunk = void (*)(const Closure* const* closures, const Offset* rows, std::byte* memory,
                       std::size_t count, std::size_t* current, std::size_t carried);
inline constexpr std::size_t kNoArgument = static_cast<std::size_t>(-1);

/// One entry of a calculation's declared arguments.
struct Slot {
  enum class What {
    kSource,
    kTime,
    kList,  ///< one argument made of the next `count` entries
  };
  What what;
  const Source* source = nullptr;
  std::uint32_t count = 0;
};

}  // namespace internal

/// The kind of a Source, which decides where its value is kept and when it is computed.
enum class SourceKind {
  kInput,       ///< an input port; its driver provides the value
  kOutput,      ///< an output port with a calculation, or with a driver (a state, an inner port)
  kContinuous,  ///< a continuous state
  kDerivative,  ///< the time derivative of a continuous state
  kDiscrete,    ///< a discrete state or mode
  kParameter,   ///< a value that only Context::Set changes
  kUpdate,      ///< the next value of a state
  kShared,      ///< a value that several calculations of a block use
  kScratch,     ///< memory of one calculation, saved and cloned
  kWorkspace,   ///< memory of one calculation, made anew for every context
  kRandom,      ///< a stream of random numbers
  kWitness,     ///< a function whose zero crossing is an event
  kKink,        ///< the index of the smooth piece on which a block's calculations are
  kNextJump,    ///< the next instant at which a block's calculations jump
  kMonitor,     ///< a check that can end a run
  kPublish,     ///< a side effect
};

class Witness;

/// Trigger: after every accepted step of the integrator.
struct EachStep {};
/// Trigger: once, before the first tick of a run.
struct AtStart {};

/// When an Update or a Publish runs: Sampled{rate}, EachStep{}, AtStart{} or a Witness.
struct Trigger {
  enum class When { kAlways, kSampled, kEachStep, kAtStart, kWitness };
  Trigger() = default;
  Trigger(Sampled when_due) : when(When::kSampled), sampled(when_due) {}
  Trigger(EachStep) : when(When::kEachStep) {}
  Trigger(AtStart) : when(When::kAtStart) {}
  Trigger(const Witness& crossed);

  When when = When::kAlways;
  Sampled sampled{Rate::FromPeriod(1, 1)};
  const Witness* witness = nullptr;
};

/// A value inside a block: a port, a state, a shared value, a next value. Sources register with their block
/// and are never copied or moved. Blocks use the typed classes derived from this one; this is their common
/// base.
class Source : public internal::Declared {
 public:
  SourceKind kind() const { return kind_; }
  const Spec& spec() const { return spec_; }
  const std::string& name() const { return spec_.name; }
  const System& owner() const { return *owner_; }
  /// The path of the block and the name, such as "robot.pd.u".
  std::string path() const;
  /// The type of the value as written in code: "LeggedState", "Vec<12>", "double".
  std::string type_name() const;
  /// The description of the value's type.
  const internal::TypeInfo& type() const { return *type_; }
  /// Names and units of the elements of the value. Sizes known only at run time are those of the initial
  /// value.
  std::vector<Element> elements() const;
  /// The elements of the initial value: of a state at the start, or of an optional input while unconnected.
  std::vector<double> initial_numbers() const;
  /// True for an input that has a default and need not be connected.
  bool is_optional() const { return kind_ == SourceKind::kInput && has_initial_value_; }
  const Trigger& trigger() const { return trigger_; }
  bool is_sampled() const { return trigger_.when == Trigger::When::kSampled; }
  /// The sources that its calculation uses, without the time.
  std::vector<const Source*> uses() const;
  /// The state of a derivative or an update; null for other sources.
  const Source* target() const { return target_; }
  /// The source whose initial value has the size that the value of this one, a matrix of run-time size, must
  /// have; null if none declares it. Known once the diagram is built.
  const Source* declares_size() const { return declares_size_; }
  /// The source that this port is directly connected to; null if there is none.
  const Source* driver() const { return driver_; }
  void AppendTo(std::vector<internal::Slot>& slots) const {
    slots.push_back({internal::Slot::What::kSource, this});
  }
  /// Returns this source, or, if its block or an enclosing diagram was replaced (see
  /// DiagramBuilder::Replace), the source that now has its path and type. Figures and reports of a shipped
  /// diagram find their sources this way. Throws BuildError that names what the new block lacks.
  const Source& Current() const;
  /// The source that provides this port's value: a state, a calculation or an open input, found through all
  /// connections.
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
  /// Lets calculations with equal functions of the same values be computed once.
  template <class F>
  void SetComparison() {
    equal_ = [](const internal::Closure& a, const internal::Closure& b) {
      return static_cast<const internal::ClosureOf<F>&>(a).function ==
             static_cast<const internal::ClosureOf<F>&>(b).function;
    };
  }
  void SetDriver(const Source& driver) { driver_ = &driver; }
  void SetTarget(const Source& target) { target_ = &target; }
  void SetTrigger(Trigger trigger) { trigger_ = trigger; }
  void SetComesFromOutside() { comes_from_outside_ = true; }
  void SetIsCopy() { is_copy_ = true; }
  void SetHasInitialValue() { has_initial_value_ = true; }
  void CheckUses(int undeclared, bool merged) const;
  const void* model() const { return model_; }

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
  const void* model_;  ///< initial value; stored in the derived class
  const Source* driver_ = nullptr;
  bool ignores_units_ = false;      ///< the connection to the driver ignores units
  const Source* target_ = nullptr;  ///< the state of an update or a derivative
  Trigger trigger_;
  bool comes_from_outside_ = false;  ///< an ExternalPort
  bool is_copy_ = false;             ///< the value is a copy of the one value that it uses
  bool has_initial_value_ = false;   ///< a sampled output is readable before its first tick

  internal::Thunk run_ = nullptr;
  std::unique_ptr<internal::Closure, internal::Closure::Delete> closure_;
  std::vector<internal::Slot> arguments_;
  bool (*equal_)(const internal::Closure&, const internal::Closure&) = nullptr;  ///< null: not comparable

  // Set when the diagram is built.
  internal::Offset offset_ = 0;
  int calculation_ = -1;  ///< index among the diagram's calculations
  const Source* declares_size_ =
      nullptr;  ///< the source whose initial value has the size that this one needs
};

/// Returns the source that is now in the place of `source`, see Source::Current, or null if the new block has
/// none.
const Source* FindCurrent(const Source& source);
template <class Port>
const Port* FindCurrent(const Port& port) {
  return static_cast<const Port*>(FindCurrent(static_cast<const Source&>(port)));
}

/// Source::Current, cast to the type of the port.
template <class Port>
const Port& Current(const Port& port) {
  return static_cast<const Port&>(port.Current());
}

}  // namespace tenon
