#pragma once

#include <tenon/apps/common/customisation.h>
#include <tenon/apps/common/scenario_app.h>
#include <tenon/diagrams/guide_dog/guide_dog.h>

namespace tenon::apps {

/// The app tenon-guide-dog. A program with a block of its own, such as a supervisor, is written as for
/// QuadrupedApp.
class GuideDogApp : public Customisable<GuideDogApp, GuideDog> {
 public:
  /// The main function, see RunApp.
  int Run(int argc, char** argv) const;
  /// The app for campaigns.
  ScenarioApp AsScenarioApp() const;
};

}  // namespace tenon::apps
