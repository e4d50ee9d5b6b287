// A program with hidden symbols can catch the errors of the libraries by their type.

#include <tenon/plants/legged/quadruped_plant.h>
#include <tenon/systems/simulation.h>

#include <cstdio>
#include <string>

struct Bad {
  double value = 0;
  static tenon::FieldList Fields() { return {{"value", &Bad::value, "N"}}; }
};

int main() {
  int caught = 0;
  tenon::DiagramBuilder builder;
  try {
    builder.Add<tenon::QuadrupedPlant>("plant");  // without a robot
  } catch (const tenon::ParameterError& error) {
    caught += std::string(error.what()).starts_with("block 'plant'");
  }
  auto& bad = builder.AddFunction("bad", tenon::Uses(builder.time), [](double t) -> Bad {
    if (t > 0) throw tenon::ParameterError("of my own");
    return {t};
  });
  const auto diagram = builder.Build();
  tenon::Simulator simulator(*diagram);
  const auto log = simulator.AddLog(tenon::Hz(10), {&bad});
  try {
    simulator.RunTo(1);
  } catch (const tenon::RunError& error) {
    caught += std::string(error.what()).find("of my own") != std::string::npos;
  }
  caught += log->names().at(1) == "bad.output.value";
  std::printf("%d of 3\n", caught);
  return caught == 3 ? 0 : 1;
}
