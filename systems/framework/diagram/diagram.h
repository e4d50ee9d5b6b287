#pragma once

#include <tenon/systems/framework/diagram/diagram_builder.h>

namespace tenon {

class Context;

namespace internal {
struct Program;
}

/// A compiled diagram. It is immutable: all that changes is kept in a Context, so several threads can run one
/// diagram, each with its own context. Contexts keep the diagram alive.
class Diagram : public std::enable_shared_from_this<Diagram> {
 public:
  Diagram(const Diagram&) = delete;
  Diagram& operator=(const Diagram&) = delete;
  ~Diagram();

  /// Returns a context at t = 0 with initial states. Random streams are seeded by `seed` and the block's
  /// path.
  std::unique_ptr<Context> CreateContext(std::uint64_t seed = 0) const;

  /// Returns the block with this path. Throws Error with the nearest path if there is none.
  const System& FindBlock(std::string_view path) const;
  /// Returns the port, state or shared value with this path ("robot.pd.u"). Throws Error with the nearest
  /// path if there is none.
  const Source& Find(std::string_view path) const;

  int num_continuous_states() const;
  /// True if the diagram has sample times.
  bool has_samples() const;
  /// Path and element name of every scalar of the continuous state vector, in order: "cart.x.velocity".
  std::vector<std::string> ContinuousStateNames() const;
  /// Inputs without connection or default (only in diagrams built with BuildWithOpenInputs).
  const std::vector<const Source*>& open_inputs() const;
  /// The top-level blocks; subdiagrams contain further blocks.
  const std::vector<std::unique_ptr<System>>& blocks() const { return blocks_; }
  /// All Parameters, in the order of the blocks.
  std::vector<const internal::ParameterSource*> parameters() const;
  /// The diagram as text: blocks with their ports, units and rates; the order of the calculations at each
  /// tick; the calculations that the integrator evaluates, and the events that restart it.
  std::string Describe() const;
  /// The diagram as Graphviz source: blocks, port names, sample periods in colour, subdiagrams as boxes.
  std::string Graphviz() const;

  const internal::Program& program() const { return *program_; }

 private:
  friend class DiagramBuilder;
  Diagram(std::vector<std::unique_ptr<System>> blocks, std::vector<std::unique_ptr<System>> replaced,
          std::unique_ptr<const internal::Program> program);

  std::vector<std::unique_ptr<System>> blocks_;
  std::vector<std::unique_ptr<System>> replaced_;  ///< kept for references that users hold
  std::unique_ptr<const internal::Program> program_;
};

}  // namespace tenon
