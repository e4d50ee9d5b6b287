// tenon-observer-order: compares orders and gains of the leg observer on a constant force.

#include <tenon/apps/common/command_line.h>
#include <tenon/apps/studies/observer_order_study.h>

int main(int argc, char** argv) {
  using namespace tenon::apps;
  CommandLine line("Compares orders and gains of the leg observer on a constant force.",
                   "tenon-observer-order");
  CommonArguments arguments;
  AddCommonArguments(line, arguments);
  return RunMain(line, argc, argv, [&]() -> int {
    const ScenarioApp app = ObserverOrderApp();
    if (PrintsInstead(arguments, app)) return kRan;
    return StudyObserverOrders(LoadScenario(arguments, app.name), arguments.duration, OptionsOf(arguments));
  });
}
