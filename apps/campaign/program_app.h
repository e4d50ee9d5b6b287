#pragma once

#include <tenon/apps/common/scenario_app.h>

namespace tenon::apps {

/// Makes an app of a separate program whose main function calls RunApp. Each run is a process, and its
/// figures are read from its summary.json. The program itself refuses scenarios of other apps. Throws
/// ParameterError if it is not executable.
ScenarioApp ProgramApp(const std::filesystem::path& program);

}  // namespace tenon::apps
