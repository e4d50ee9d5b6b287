// tenon-robot: makes a robot that walks from a URDF.

#include <tenon/apps/common/command_line.h>
#include <tenon/apps/quadruped/robot_proposal_run.h>

int main(int argc, char** argv) {
  using namespace tenon::apps;
  CLI::App line("Makes a robot's YAML file from its URDF, draws it, lets it stand and trot.", "tenon-robot");
  RobotArguments arguments;
  line.add_option("URDF", arguments.urdf, "URDF of a quadruped with three joints per leg, see docs/robots.md")
      ->required();
  line.add_option("--out", arguments.out,
                  "directory for NAME.yaml, the URDF, NAME.svg and the trial runs (default: out/NAME)");
  line.add_option("--lock", arguments.locks, "a joint to fix, and its angle [rad]: --lock arm_1=0.5")
      ->type_name("JOINT=ANGLE")
      ->allow_extra_args(false);
  line.add_option(
      "--forward", arguments.forward,
      "axis of the trunk's link along which the robot faces: x, y, z, -x, -y or -z (default: found from "
      "joints and names)");
  line.add_flag("--strict", arguments.strict,
                "refuse inertias that no body can have, instead of correcting them");
  line.footer(
      "Exit codes: 0 the robot trots; 2 bad usage or URDF; 3 it fell or exceeded physical limits; 4 "
      "numerical "
      "failure; 5 a file could not be written; 130, 143 stopped by Ctrl-C, SIGTERM.");
  return RunMain(line, argc, argv, [&] { return ProposeRobot(arguments); });
}
