// tenon-cdpr: flies a cable-driven parallel robot along a path.

namespace tenon::apps {
int CdprMain(int argc, char** argv);  // in cdpr_app.cc; including the app's header would take seconds
}

int main(int argc, char** argv) {
  return tenon::apps::CdprMain(argc, argv);
}
