#pragma once

#include <tenon/apps/common/customisation.h>
#include <tenon/diagrams/guide_dog/guide_dog.h>

namespace tenon::apps {

/// The app tenon-guide-dog. See QuadrupedApp for a program with a block of its own, such as a supervisor.
class GuideDogApp : public Customisable<GuideDogApp, GuideDog> {
 public:
  /// The main function, see RunApp.
  int Run(int argc, char** argv) const { return RunApp(AsScenarioApp(), argc, argv); }
  /// Returns the app for campaigns.
  ScenarioApp AsScenarioApp() const;
};

}  // namespace tenon::apps
