#pragma once

#include <tenon/systems/yaml/yaml.h>

#include <string>
#include <vector>

namespace tenon::apps {

struct GaitStabilityOptions {
  int settle = 20;                  ///< strides before the linearized one
  int strides = 8;                  ///< strides over which the decay of a push is compared
  double push = 0.005;              ///< change of the trunk's velocity to the left [m/s]
  std::vector<double> steps{1e-5};  ///< step sizes of the finite differences
};

/// Linearizes the stride of a walking robot without disturbances. Prints the Floquet multipliers, the
/// eigenvalues of the stride map, and compares the decay of a small push in the linear model with the
/// simulation. `name` is printed as that of the scenario. Returns the exit code. Throws ParameterError with
/// the place of a value that is not possible, and RunError if the robot falls.
int StudyGaitStability(const YamlDocument& document, const std::string& name,
                       const GaitStabilityOptions& options);

}  // namespace tenon::apps
