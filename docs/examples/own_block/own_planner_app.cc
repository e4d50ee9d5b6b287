// tenon-quadruped with a custom swing planner: `own_planner_app A1 --set custom.height_m=0.08 --compare`

#include <tenon/apps/quadruped/quadruped_app.h>

#include "../compose/arc_planner.h"

struct Keys {
  double height_m = 0.06;
  static tenon::FieldList Fields() { return {{"height_m", &Keys::height_m}}; }
};

int main(int argc, char** argv) {
  return tenon::apps::QuadrupedApp()
      .Customise<Keys>([](tenon::DiagramBuilder& builder, tenon::QuadrupedWalk& walk, const Keys& keys) {
        builder.Replace<ArcPlanner>(
            walk.locomotion.swing_planner,
            {.robot = walk.locomotion.whole_body.params.robot, .height = keys.height_m});
      })
      .Run(argc, argv);
}
