#pragma once

#include <tenon/apps/common/customisation.h>
#include <tenon/diagrams/faults/faults.h>

namespace tenon::apps {

/// Returns the result of `insert`, a call of InsertFaults with the faults of a scenario. Throws KeyError with
/// the key of a fault that is invalid.
template <class F>
decltype(auto) BlameFaults(F insert) {
  try {
    return insert();
  } catch (const FaultError& error) {
    throw KeyError("faults." + std::to_string(error.index()) + ".at", error.what());
  } catch (const ParameterError& error) {
    throw KeyError("faults", error.what());
  }
}

/// Adds the diagram of a scenario to the builder, with the parameters that `params()` returns, the change of
/// a user's program and the faults of the scenario, whose signals `faults` receives. Throws KeyError.
template <class Diagram>
Diagram& AddDiagram(DiagramBuilder& builder, const auto& params, const Customisation<Diagram>& customisation,
                    const auto& scenario, Outputs& outputs, std::vector<const Source*>& faults) {
  auto& diagram = Blame("", [&]() -> Diagram& { return builder.Add<Diagram>("loop", params()); });
  customisation.Apply(builder, diagram, scenario.custom, outputs);
  faults = BlameFaults([&] { return InsertFaults(builder, diagram, scenario.faults); });
  return diagram;
}

}  // namespace tenon::apps
