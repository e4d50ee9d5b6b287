#pragma once

#include <tenon/apps/common/customisation.h>
#include <tenon/diagrams/cdpr/cdpr_loop.h>

namespace tenon::apps {

/// The app tenon-cdpr. See QuadrupedApp for a program with a block of its own, such as a controller.
class CdprApp : public Customisable<CdprApp, CdprLoop> {
 public:
  /// The main function: reads the command line (see --help), runs the scenario once or once for each
  /// controller, prints the figures and returns the exit code. Errors are printed on stderr.
  int Run(int argc, char** argv) const;
  /// Returns the app for campaigns.
  ScenarioApp AsScenarioApp() const;
};

}  // namespace tenon::apps
