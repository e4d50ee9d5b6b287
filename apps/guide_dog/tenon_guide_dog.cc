// tenon-guide-dog: a quadruped that leads a person on a leash.

namespace tenon::apps {
int GuideDogMain(int argc,
                 char** argv);  // in guide_dog_app.cc; including the app's header would take seconds
}

int main(int argc, char** argv) {
  return tenon::apps::GuideDogMain(argc, argv);
}
