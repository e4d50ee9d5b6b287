#pragma once

#include <tenon/systems/framework/block/internal/rational.h>
#include <tenon/systems/framework/block/source.h>

#include <algorithm>
#include <functional>
#include <unordered_map>

namespace tenon::internal {

/// One entry of a flat list of calculations that a run executes.
struct Op {
  Thunk run;
  const Closure* closure;
  const Offset* row;
  std::uint32_t calculation;  ///< index in Program::calculations
  bool varies;                ///< depends on time or continuous states other than through samples
  bool always;                ///< run even if its stamp is fresh: due samples, updates
};
using OpList = std::vector<Op>;

/// Consecutive ops of the same code, run by one call.
struct Batch {
  Thunk run;
  std::size_t begin, count;  ///< range of ops and of closures
  std::size_t rows;          ///< index of the first row
  std::size_t carried;       ///< see Thunk
};

/// A list that is run many times, ordered so that ops of the same code are adjacent as far as their
/// dependencies permit.
struct BatchedOps {
  OpList ops;
  std::vector<Batch> batches;
  std::vector<const Closure*> closures;
  std::vector<Offset> rows;
};

/// A calculation of the program. Calculations are numbered in dataflow order.
struct CalculationInfo {
  const Source* source;
  Op op;
  std::vector<int> uses;          ///< calculations whose results it reads
  bool varies;                    ///< see Op::varies
  bool sampled;                   ///< a sampled output, held between its ticks
  bool settled = true;            ///< depends only on Parameters, directly or indirectly
  int group = -1;                 ///< index of its sample group; -1 if it is not sampled
  bool feeds = false;             ///< affects a derivative or a witness, directly or indirectly
  std::vector<int> affects = {};  ///< calculations that read its result
};

/// Calculations that share a sample time.
struct SampleGroup {
  Rational period;
  Rational offset;
  std::string example;  ///< the path of one member, for messages
  bool feeds = false;   ///< a member affects a derivative or witness: its ticks end integrator steps
};

/// Indices of sample groups that are due together, ascending.
using Groups = std::vector<int>;

/// The effect of a computed update: state = next.
struct Commit {
  const Source* state;
  const Source* next;
};

/// Updates with the same trigger.
struct UpdatePlan {
  OpList ops;  ///< the updates after their prerequisites
  std::vector<Commit> commits;
  std::vector<std::uint32_t> invalidates;  ///< held calculations that depend on the new values
  std::vector<ScalarRun> doubles;  ///< locations of doubles among the next values, for the check for NaN
  std::vector<const Source*> inspected;  ///< next values with other real numbers, for the same check
  bool changes_continuous = false;
  bool feeds = false;  ///< the updates restart the integrator
  bool empty() const { return ops.empty(); }
};

/// Everything that happens at a tick, for one combination of due sample groups.
struct TickPlan {
  Groups groups;
  bool feeds = false;                      ///< the tick restarts the integrator
  std::vector<std::uint32_t> invalidates;  ///< calculations downstream of the due outputs
  OpList outputs;                          ///< due sampled outputs and their prerequisites, in dataflow order
  std::vector<const Source*> due;          ///< the due sampled outputs, for the check for NaN
  std::vector<ScalarRun> doubles;          ///< locations of their doubles at fixed offsets
  std::vector<const Source*> inspected;    ///< outputs with other real numbers
  OpList monitors;                         ///< due monitors and their prerequisites
  std::vector<const Source*> verdicts;
  UpdatePlan updates;
};

/// Returns whether the numbers are finite; `memory` is a context's.
inline bool AllFinite(const std::byte* memory, std::span<const ScalarRun> doubles) {
  return std::ranges::all_of(doubles, [&](const ScalarRun& run) {
    return AllFinite(reinterpret_cast<const double*>(memory + run.offset), run.count);
  });
}

/// A Witness with its updates, or a Kink, which has none.
struct WitnessPlan {
  const Source* witness;
  UpdatePlan updates;
  bool is_kink;
};

/// The location of a stored value in a context's memory.
struct Cell {
  const Source* source;
  Offset offset;
};

/// A value of run-time size whose numbers are also stored among the continuous states or their derivatives.
struct Unpacked {
  const Source* source;
  Offset offset;  ///< place of the copy among the states or derivatives
  std::size_t count;
};

enum class Which { kVarying, kHeld, kAll };

/// A compiled diagram: flat lists, and the layout of a context's memory:
/// time | continuous states | their derivatives | values that are copied as bytes | other values.
struct Program {
  /// Calculations that `sinks` depend on, in dataflow order, including those `sinks` that are sampled
  /// outputs. Sampled outputs are included only if they are in the `due` groups: the others are held.
  OpList Needed(const std::vector<const Source*>& sinks, Which which, const Groups& due = {}) const;
  /// These calculations, and then the `sinks` themselves, always.
  OpList NeededWithSinks(const std::vector<const Source*>& sinks, Which which) const;
  /// Calculations that depend on the results of `changed`, without `changed` themselves.
  std::vector<std::uint32_t> Downstream(std::vector<int> changed) const;
  UpdatePlan MakeUpdates(const std::vector<const Source*>& updates) const;
  /// Plan of a tick. Plans are made when needed, because few of the many combinations of groups occur.
  TickPlan MakeTick(const Groups& due) const;
  /// Calculations for the values of `sources`, with all prerequisites.
  OpList Evaluation(const std::vector<const Source*>& sources) const;
  /// `ops`, reordered and divided into batches.
  BatchedOps Batched(const OpList& ops) const;
  OpList Gathered(const OpList& ops) const;
  /// Consecutive ops of the same code, each of which takes the previous result as the same argument.
  struct Chain {
    std::size_t end;
    std::size_t carried;
  };
  Chain ChainFrom(const OpList& ops, std::size_t begin) const;
  /// Index of the argument of `next` that is the result of `op`; kNoArgument if there is none.
  std::size_t ArgumentFrom(const Op& op, const Op& next) const;
  /// Appends the rows of calculations of the same code, then their lists; see Thunk.
  static void AppendRows(std::span<const Source* const> sources, std::vector<Offset>& rows);

  /// For Slow: see internal::Defer and internal::ModelOf.
  static void Defer(Source& output, Source& result);
  static const void* ModelOf(const Source& source);

  std::vector<CalculationInfo> calculations;
  std::vector<Offset> rows;  ///< rows of all calculations

  Offset continuous_begin = 0;
  Offset derivative_begin = 0;
  int num_continuous = 0;
  std::size_t memory_size = 0;
  std::vector<Cell> cells;    ///< every stored value
  std::vector<Cell> objects;  ///< the cells that are copied by their type
  std::vector<Cell> saved;    ///< the cells that a snapshot contains
  std::vector<Unpacked> unpacked_states;
  std::vector<Unpacked> unpacked_derivatives;

  BatchedOps derivatives;  ///< varying calculations for the derivatives, and the derivatives
  OpList held;             ///< other calculations for derivatives or witnesses
  BatchedOps witnesses;    ///< varying calculations for the witnesses, and the witnesses
  std::vector<WitnessPlan> witness_plans;

  std::vector<SampleGroup> groups;
  /// Calculations, other than samples, that read a discrete state.
  std::unordered_map<const Source*, std::vector<int>> readers;
  OpList jumps;                           ///< NextJumps of feeding blocks with their prerequisites
  std::vector<const Source*> next_jumps;  ///< NextJumps of feeding blocks

  UpdatePlan at_start;
  OpList published_at_start;
  UpdatePlan each_step;
  OpList each_step_monitors;
  std::vector<const Source*> each_step_verdicts;

  std::vector<const Source*> continuous;  ///< states in the order of the vector
  std::vector<const Source*> open_inputs;
  std::uint64_t signature = 0;  ///< hash of names, types and layout, stored in snapshots
};

/// Calls `visit` for each block, and for those in a subdiagram after it.
void ForEachBlock(const std::vector<std::unique_ptr<System>>& blocks,
                  const std::function<void(const System&)>& visit);

}  // namespace tenon::internal
