// The main function of an app, which calls TENON_MAIN of the app's library: including the app's header would
// take seconds.

namespace tenon::apps {
int TENON_MAIN(int argc, char** argv);
}

int main(int argc, char** argv) {
  return tenon::apps::TENON_MAIN(argc, argv);
}
