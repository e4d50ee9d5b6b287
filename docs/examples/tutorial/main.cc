#include <tenon/apps/quadruped/quadruped_app.h>

#include "momentum_observer.h"

struct Keys {  // the map `custom` of a scenario
  double bandwidth_rad_per_s = 25;
  static tenon::FieldList Fields() { return {{"bandwidth_rad_per_s", &Keys::bandwidth_rad_per_s}}; }
};

int main(int argc, char** argv) {
  return tenon::apps::QuadrupedApp()
      .Customise<Keys>([](tenon::DiagramBuilder& builder, tenon::QuadrupedWalk& walk, const Keys& keys) {
        builder.Replace<MomentumObserver>(walk.observer, {.robot = walk.locomotion.whole_body.params.robot,
                                                          .bandwidth = keys.bandwidth_rad_per_s});
      })
      .Run(argc, argv);
}
