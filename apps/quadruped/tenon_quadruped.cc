// tenon-quadruped: a quadruped that stands, drops, or walks.

namespace tenon::apps {
int QuadrupedMain(int argc,
                  char** argv);  // in quadruped_app.cc; including the app's header would take seconds
}

int main(int argc, char** argv) {
  return tenon::apps::QuadrupedMain(argc, argv);
}
