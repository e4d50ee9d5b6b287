// tenon-gait-stability: the Floquet multipliers of a walking robot.

#include <tenon/apps/common/command_line.h>
#include <tenon/apps/quadruped/quadruped_app.h>
#include <tenon/apps/studies/gait_stability_study.h>

int main(int argc, char** argv) {
  using namespace tenon::apps;
  CommandLine line("Linearises the stride of a walking quadruped and prints its Floquet multipliers.",
                   "tenon-gait-stability");
  CommonArguments arguments;
  AddScenarioArguments(line, arguments);
  line.SetFooter(
      "Writes no files: all results are printed. The last segment of the walk is extended without end, and\n"
      "disturbances are removed.\n"
      "Exit codes: 0 analysed; 2 bad usage or scenario; 4 the robot fell, or numerical failure.");
  GaitStabilityOptions options;
  line.Add("--settle", &options.settle, "number of strides before the one that is linearised",
           {.range = OptionRange::kNotNegative});
  line.Add("--strides", &options.strides, "number of strides over which the decay of a push is compared",
           {.range = OptionRange::kPositiveInteger});
  line.Add("--push", &options.push, "change of the trunk's velocity to the left [m/s]");
  line.Add("--steps", &options.steps, "step sizes of the finite differences");
  return RunMain(line, argc, argv, [&]() -> int {
    const ScenarioApp app = QuadrupedApp().AsScenarioApp();
    if (PrintsInstead(arguments, app)) return kRan;
    return StudyGaitStability(LoadScenario(arguments, app.name), arguments.scenario, options);
  });
}
