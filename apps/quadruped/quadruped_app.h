#pragma once

#include <tenon/apps/common/customisation.h>
#include <tenon/diagrams/legged/quadruped_walk.h>

namespace tenon::apps {

/// The app tenon-quadruped. A program with a block of its own runs all walking scenarios with the options,
/// hardware, faults, figures, report and live page of the shipped app; a campaign runs it by `app: ./my_app`:
///
///     using tenon::QuadrupedWalk, tenon::DiagramBuilder;
///     int main(int argc, char** argv) {
///       return tenon::apps::QuadrupedApp()
///           .Customise<Keys>([](DiagramBuilder& builder, QuadrupedWalk& walk, const Keys& keys) {
///             builder.Replace<MyObserver>(walk.observer, {.gain = keys.gain_per_s});
///           })
///           .Run(argc, argv);
///     }
class QuadrupedApp : public Customisable<QuadrupedApp, QuadrupedWalk> {
 public:
  /// The main function: reads the command line (see --help), runs the scenario once, or once for each
  /// observer, prints the figures and returns the exit code. Errors are printed on stderr.
  int Run(int argc, char** argv) const;

  /// Returns the app for campaigns.
  ScenarioApp AsScenarioApp() const;
};

}  // namespace tenon::apps
