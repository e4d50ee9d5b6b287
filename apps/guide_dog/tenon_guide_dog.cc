// tenon-guide-dog: a quadruped that leads a person on a leash.

#include <tenon/apps/common/command_line.h>
#include <tenon/apps/common/outputs.h>
#include <tenon/apps/guide_dog/guide_dog_run.h>

namespace tenon::apps {
namespace {

int Run(const CommonArguments& arguments) {
  if (arguments.list) {
    ListScenarios("tenon-guide-dog");
    return kRan;
  }
  const YamlDocument document = LoadScenario(arguments, "tenon-guide-dog");
  auto scenario = document.Read<GuideDogScenario>();
  if (arguments.duration) scenario.duration_s = *arguments.duration;
  return RunBlaming(document, [&] {
    const Summary summary = RunGuideDog(scenario, OptionsOf(arguments)).summary;
    summary.Print();
    return summary.exit_code();
  });
}

}  // namespace
}  // namespace tenon::apps

int main(int argc, char** argv) {
  CLI::App app("Lets a quadruped lead a person on a leash and reports how well it did.", "tenon-guide-dog");
  tenon::apps::CommonArguments arguments;
  tenon::apps::AddCommonArguments(app, arguments);
  return tenon::apps::RunMain(app, argc, argv, [&] { return tenon::apps::Run(arguments); });
}
