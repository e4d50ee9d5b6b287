#include <tenon/controllers/cdpr/reference_generator.h>

namespace tenon {

void ReferenceGeneratorParams::Validate() const {
  Demand(path != nullptr, "no path given: make an EquilibriumPath and share it");
}

}  // namespace tenon
