#pragma once

#include <tenon/apps/common/scenario_app.h>

#include <filesystem>

namespace tenon::apps {

/// An app that is a program of its own, made with RunApp: each run is a process, and its figures are those of
/// the summary.json that it leaves. Its name is the file's. Throws ParameterError if it cannot be run.
ScenarioApp ProgramApp(const std::filesystem::path& program);

}  // namespace tenon::apps
