#include <tenon/apps/common/command_line.h>
#include <tenon/apps/common/scenario_app.h>

#include <fmt/core.h>

namespace tenon::apps {

FieldList AppScenario::With(FieldList own) {
  own.insert(own.begin(),
             {{"duration_s", &AppScenario::duration_s}, {"log_rate_hz", &AppScenario::log_rate_hz}});
  return CommonScenario::With(own);
}

int RunApp(const ScenarioApp& app, int argc, char** argv) {
  CommandLine line(app.description, ProgramName(argv));
  CommonArguments arguments;
  AddCommonArguments(line, arguments);
  AddLiveArguments(line, arguments);
  AddFigureArgument(line, app, arguments);
  return RunMain(line, argc, argv, [&]() -> int {
    if (const auto code = RunInstead(arguments, app)) return *code;
    return RunLive(arguments, [&](const CommonArguments& now, const RunOptions& options) {
      const YamlDocument document = LoadScenario(now, app.name);
      if (app.warnings)
        for (const std::string& warning : app.warnings(document)) Say(fmt::format("warning: {}\n", warning));
      return PrintResult(app.run(document, now.duration, options).summary, options);
    });
  });
}

}  // namespace tenon::apps
