// tenon-guide-dog: a quadruped that leads a person on a leash.

#include <tenon/apps/guide_dog/guide_dog_app.h>

int main(int argc, char** argv) {
  return tenon::apps::GuideDogApp().Run(argc, argv);
}
