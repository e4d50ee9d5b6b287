#pragma once

#include <tenon/systems/framework/diagram/diagram_builder.h>

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace tenon {

class Context;

namespace internal {
struct Program;
}

/// A compiled diagram. Constant: whatever changes lives in a Context, so several threads can run one diagram,
/// each with a context of its own. Contexts keep it alive.
class Diagram : public std::enable_shared_from_this<Diagram> {
 public:
  Diagram(const Diagram&) = delete;
  Diagram& operator=(const Diagram&) = delete;
  ~Diagram();

  /// A context at t = 0 with all states at their initial values. Random streams are seeded by (seed, path).
  std::unique_ptr<Context> CreateContext(std::uint64_t seed = 0) const;

  /// The block with this path; throws Error with the nearest name if there is none.
  const System& FindBlock(std::string_view path) const;
  /// The port, state or shared value with this path ("robot.pd.u"); throws Error with the nearest name.
  const Source& Find(std::string_view path) const;

  int num_continuous_states() const;
  /// Whether anything in it happens at sample times.
  bool has_samples() const;
  /// "cart.x.velocity": path and element name of every scalar of the continuous state vector, in its order.
  std::vector<std::string> ContinuousStateNames() const;
  /// Inputs that nothing is connected to (only in diagrams built with BuildWithOpenInputs).
  const std::vector<const Source*>& open_inputs() const;
  /// The blocks at top level; subdiagrams hold more.
  const std::vector<std::unique_ptr<System>>& blocks() const { return blocks_; }
  /// All Parameters, in the order of the blocks.
  std::vector<const internal::ParameterSource*> parameters() const;
  /// The diagram in words: blocks with their ports, units and rates; in which order what is computed at each
  /// tick; what the integrator evaluates, and what makes it start again.
  std::string Describe() const;
  /// The diagram as a Graphviz program: blocks, port names, sample periods in colour, subdiagrams as boxes.
  std::string Graphviz() const;

  const internal::Program& program() const { return *program_; }

 private:
  friend class DiagramBuilder;
  Diagram(std::vector<std::unique_ptr<System>> blocks, std::vector<std::unique_ptr<System>> replaced,
          std::unique_ptr<const internal::Program> program);

  std::vector<std::unique_ptr<System>> blocks_;
  std::vector<std::unique_ptr<System>> replaced_;  ///< at top level; users may still hold references to them
  std::unique_ptr<const internal::Program> program_;
};

}  // namespace tenon
