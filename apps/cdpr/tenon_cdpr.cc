// tenon-cdpr: flies a cable-driven parallel robot along a path.

#include <tenon/apps/cdpr/cdpr_app.h>

int main(int argc, char** argv) {
  return tenon::apps::CdprApp().Run(argc, argv);
}
