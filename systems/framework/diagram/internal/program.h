#pragma once

#include <tenon/systems/framework/block/internal/rational.h>
#include <tenon/systems/framework/block/source.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

namespace tenon::internal {

/// One entry of a flat list that a running diagram works through.
struct Op {
  Thunk run;
  const Closure* closure;
  const Offset* row;
  std::uint32_t calculation;  ///< index in Program::calculations
  bool varies;                ///< depends on time or continuous states other than through samples
  bool always;                ///< run even if its stamp is fresh: due samples, updates
};
using OpList = std::vector<Op>;

/// Ops of the same code that follow one another: one call.
struct Batch {
  Thunk run;
  std::size_t begin, count;  ///< of its ops, and of their closures
  std::size_t rows;          ///< where theirs begin
  std::size_t carried;       ///< see Thunk
};

/// A list that is worked through again and again: in an order in which ops of the same code follow one
/// another as far as what they use allows.
struct BatchedOps {
  OpList ops;
  std::vector<Batch> batches;
  std::vector<const Closure*> closures;
  std::vector<Offset> rows;
};

/// A calculation in its place in the program; they are numbered in dataflow order.
struct CalculationInfo {
  const Source* source;
  Op op;
  std::vector<int> uses;          ///< calculations whose results it reads
  bool varies;                    ///< as in `op`
  bool sampled;                   ///< a sampled output, held between its ticks
  bool settled = true;            ///< reads nothing but Parameters, by whatever way
  int group = -1;                 ///< of samples
  bool feeds = false;             ///< reaches a derivative or a witness, by whatever way
  std::vector<int> affects = {};  ///< calculations that read its result
};

/// Calculations that share a sample time.
struct SampleGroup {
  Rational period;
  Rational offset;
  std::string example;  ///< the path of one member, for messages
  bool feeds = false;   ///< one of them does: its ticks end a step of the integrator
};

/// Sample groups that are due together, by their indices, ascending.
using Groups = std::vector<int>;

/// An update that has been computed takes effect: state = next.
struct Commit {
  const Source* state;
  const Source* next;
};

/// Updates that fire together.
struct UpdatePlan {
  OpList ops;  ///< what they need, then the updates themselves
  std::vector<Commit> commits;
  std::vector<std::uint32_t> invalidates;  ///< held calculations that the new values make stale
  std::vector<ScalarRun> doubles;      ///< of the next values, from the memory's start, for the check of them
  std::vector<const Source*> movable;  ///< next values with others
  bool changes_continuous = false;
  bool feeds = false;  ///< the integrator has to start again afterwards
  bool empty() const { return ops.empty(); }
};

/// Everything that happens at a tick, for one combination of due sample groups.
struct TickPlan {
  Groups groups;
  bool feeds = false;                      ///< the integrator has to start again afterwards
  std::vector<std::uint32_t> invalidates;  ///< calculations downstream of the due outputs
  OpList outputs;                          ///< due sampled outputs and what they need, in dataflow order
  std::vector<const Source*> due;          ///< the sampled outputs, for the check for NaN:
  std::vector<ScalarRun> doubles;      ///< those of their numbers that never move, from the memory's start
  std::vector<const Source*> movable;  ///< outputs with others
  OpList monitors;                     ///< due monitors and what they need
  std::vector<const Source*> verdicts;
  UpdatePlan updates;
};

/// Whether the numbers are finite; `memory` is a context's.
inline bool AllFinite(const std::byte* memory, std::span<const ScalarRun> doubles) {
  // A sum of 0 x is 0 unless one is not finite.
  double zero = 0;
  for (const ScalarRun& run : doubles) {
    const auto* x = reinterpret_cast<const double*>(memory + run.offset);
    for (std::uint32_t i = 0; i < run.count; ++i) zero += 0 * x[i];
  }
  return zero == 0;
}

/// A Witness with its updates, or a Kink without.
struct WitnessPlan {
  const Source* witness;
  UpdatePlan updates;
  bool is_kink;
};

/// What is stored where in a context's memory.
struct Cell {
  const Source* source;
  Offset offset;
};

/// A value of run-time size whose numbers also have a place among the continuous states, or their
/// derivatives.
struct Unpacked {
  const Source* source;
  Offset offset;  ///< of that place
  std::size_t count;
};

enum class Which { kVarying, kHeld, kAll };

/// A compiled diagram: flat lists, and the layout of a context's memory:
/// time | continuous states | their derivatives | values that are copied as bytes | other values.
struct Program {
  /// What `sinks` depend on (themselves included if they are sampled outputs), in dataflow order. Sampled
  /// outputs count only if they are in the `due` groups: the others are held.
  OpList Needed(const std::vector<const Source*>& sinks, Which which, const Groups& due = {}) const;
  void AppendSinks(const std::vector<const Source*>& sinks, OpList& ops) const;
  /// What has to be computed again when the results of `changed` have changed; they themselves left out.
  std::vector<std::uint32_t> Downstream(std::vector<int> changed) const;
  UpdatePlan MakeUpdates(const std::vector<const Source*>& updates) const;
  /// Combinations of due groups are many in principle and few in practice: plans are made when they occur.
  TickPlan MakeTick(const Groups& due) const;
  /// What the values of `sources` take to compute: what they depend on, and they themselves.
  OpList Evaluation(const std::vector<const Source*>& sources) const;
  /// The same in another order, and the batches.
  BatchedOps Batched(const OpList& ops) const;
  OpList Gathered(const OpList& ops) const;
  /// Ops of the same code, from one on, of which each takes the result of the one before as the same
  /// argument.
  struct Chain {
    std::size_t end;
    std::size_t carried;
  };
  Chain ChainFrom(const OpList& ops, std::size_t begin) const;
  /// Which argument of `next` is the result of `op`; kNoArgument if none.
  std::size_t ArgumentFrom(const Op& op, const Op& next) const;
  /// The rows of calculations of the same code, see Thunk, then the lists that they point to.
  static void AppendRows(std::span<const Source* const> sources, std::vector<Offset>& rows);

  std::vector<CalculationInfo> calculations;
  std::vector<Offset> rows;  ///< of all calculations

  Offset continuous_begin = 0;
  Offset derivative_begin = 0;
  int num_continuous = 0;
  std::size_t memory_size = 0;
  std::vector<Cell> cells;    ///< every stored value
  std::vector<Cell> objects;  ///< those of them that have to be copied by their type
  std::vector<Cell> saved;    ///< those of them that a snapshot holds
  std::vector<Unpacked> unpacked_states;
  std::vector<Unpacked> unpacked_derivatives;

  BatchedOps derivatives;  ///< what varies and derivatives need, and the derivatives
  OpList held;             ///< what does not vary and derivatives or witnesses need
  BatchedOps witnesses;    ///< what varies and witnesses need, and the witnesses
  std::vector<WitnessPlan> witness_plans;

  std::vector<SampleGroup> groups;
  /// Discrete state -> calculations, other than samples, that read it.
  std::unordered_map<const Source*, std::vector<int>> readers;
  OpList jumps;                           ///< what the NextJumps of blocks that feed need, and they
  std::vector<const Source*> next_jumps;  ///< those

  UpdatePlan at_start;
  OpList published_at_start;
  UpdatePlan each_step;
  OpList each_step_monitors;
  std::vector<const Source*> each_step_verdicts;

  std::vector<const Source*> continuous;  ///< states in the order of the vector
  std::vector<const Source*> open_inputs;
  std::uint64_t signature = 0;  ///< of names, types and layout; snapshots carry it
};

}  // namespace tenon::internal
