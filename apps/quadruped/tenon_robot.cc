// tenon-robot: makes a robot that walks from a URDF.

#include <tenon/apps/common/command_line.h>
#include <tenon/apps/quadruped/robot_proposal_run.h>

int main(int argc, char** argv) {
  using namespace tenon::apps;
  CommandLine line("Makes a robot's YAML file from its URDF, draws it, lets it stand and trot.",
                   "tenon-robot");
  RobotArguments arguments;
  line.Add("URDF", &arguments.urdf, "URDF of a quadruped with three joints per leg, see docs/robots.md",
           {.required = true});
  line.Add("--out", &arguments.out,
           "directory for NAME.yaml, the URDF, NAME.svg and the trial runs (default: out/NAME)");
  line.Add("--lock", &arguments.locks, "a joint to fix, and its angle [rad or m]: --lock arm_1=0.5",
           {.type = "JOINT=ANGLE", .one_value_each = true});
  line.Add("--forward", &arguments.forward,
           "axis of the trunk's link along which the robot faces: x, y, z, -x, -y or -z (default: found from "
           "joints and names)");
  line.Add("--up", &arguments.up, "axis of the trunk's link that points up, likewise");
  line.Add("--strict", &arguments.strict,
           "refuse inertias that no body can have, instead of correcting them");
  line.SetFooter(
      "Exit codes: 0 the robot trots; 2 bad usage or URDF; 3 it fell or exceeded physical limits; 4 "
      "numerical "
      "failure; 5 a file could not be written; 130, 143 stopped by Ctrl-C, SIGTERM.");
  return RunMain(line, argc, argv, [&] { return ProposeRobot(arguments); });
}
