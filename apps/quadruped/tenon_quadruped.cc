// tenon-quadruped: a quadruped that stands, drops, or walks.

#include <tenon/apps/quadruped/quadruped_app.h>

int main(int argc, char** argv) {
  return tenon::apps::QuadrupedApp().Run(argc, argv);
}
