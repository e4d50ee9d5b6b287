#include <tenon/controllers/legged/planning/step_properties.h>
#include <tenon/systems/framework/block/system.h>

#include <fmt/core.h>

#include <cmath>

namespace tenon {}  // namespace tenon
