// Runs the walking robot and its controller as two programs in lock-step by UDP.
//
//     walk_apart                        runs both, and compares them with the walk in one program
//     walk_apart real-time [seconds]    runs both in real time; prints missed ticks and round-trip times
//     walk_apart controller [seconds]   in one terminal, first: it waits for the robot
//     walk_apart plant [seconds]        in another terminal, in real time
//
// The controller's program is the shipped walk with its world replaced; the plant's program is the world
// alone.

#include <tenon/systems/simulation.h>

#include "../compose/walk.h"
#include "remote.h"
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <functional>
#include <stdexcept>
#include <string>

namespace {

using Rows = std::vector<double>;

// Returns state and torque at every tick.
Rows Run(tenon::Simulator& simulator, const tenon::Source& state, const tenon::Source& torque, double end) {
  const auto log = simulator.AddLog(kRate, {&state, &torque});
  simulator.RunTo(end);
  Rows rows;
  for (std::size_t i = 0; i < log->rows(); ++i)
    rows.insert(rows.end(), log->row(i).begin(), log->row(i).end());
  return rows;
}

struct Controller {
  explicit Controller(const Link& link) { builder.Replace<RemoteWorld>(walk.world, link); }
  tenon::DiagramBuilder builder;
  tenon::QuadrupedWalk& walk = builder.Add<tenon::QuadrupedWalk>("loop", TrotParams());
  void Run(double end) { tenon::Simulator(builder.Build()).RunTo(end); }
};

// The robot has the name that it has in the walk, because the noise of its sensors depends on their paths.
struct Plant {
  explicit Plant(const Link& link) : robot(builder.Add<RobotOnly>("loop", TrotParams().world, link)) {}
  tenon::DiagramBuilder builder;
  RobotOnly& robot;
};

void RunByTheClock(const Link& link, double end) {
  Plant plant(link);
  tenon::SimulatorOptions options = tenon::RecommendedOptions(plant.robot.world);
  options.real_time_rate = 1;
  tenon::Simulator simulator(plant.builder.Build(), options);
  simulator.RunTo(end);
  const auto& state = simulator.context().Eval(plant.robot.world.state);
  std::printf("t = %g s: the trunk is at x = %.3f m, z = %.3f m\n", end, state.p_WB[0], state.p_WB[2]);
  const tenon::RealTimeStatistics& ticks = simulator.real_time();
  std::printf("%ld of %ld ticks began over 1 ms late; the latest one by %.2f ms at t = %.3f s\n",
              ticks.missed, ticks.ticks, 1e3 * ticks.worst_lateness, ticks.worst_time);
  Rows& trips = plant.robot.stopwatch.trips;
  std::sort(trips.begin(), trips.end());
  const auto quantile = [&](double part) {
    return 1e6 * trips[static_cast<std::size_t>(part * double(trips.size() - 1))];
  };
  std::printf("round trips [us]: half within %.0f, 99 %% within %.0f, 99.9 %% within %.0f, all within %.0f\n",
              quantile(0.5), quantile(0.99), quantile(0.999), quantile(1));
}

// Runs the controller in a second process while `plant` runs. Returns whether it succeeded. Its ports are
// open before the plant sends.
bool WithController(const Link& link, double end, const std::function<void()>& plant) {
  Controller controller(link);
  const pid_t child = fork();
  if (child == 0) {
    int code = 1;
    try {
      controller.Run(end);
      code = 0;
    } catch (const std::exception& error) {
      std::fprintf(stderr, "controller: %s\n", error.what());
    }
    _exit(code);
  }
  if (child < 0) throw std::runtime_error("fork() failed: there is no second process for the controller");
  plant();
  int status = 1;
  waitpid(child, &status, 0);
  return status == 0;
}

// Loopback addresses made from the process id, so that several such programs can run at once.
Link OwnLink() {
  const auto process = static_cast<unsigned>(getpid());
  Link link;
  link.plant = link.controller = "127." + std::to_string(process >> 16 & 127) + "." +
                                 std::to_string(process >> 8 & 255) + "." + std::to_string(process & 255);
  return link;
}

int Compare(double end) {
  const Link link = OwnLink();
  Rows apart;
  const bool ended = WithController(link, end, [&] {
    Plant plant(link);
    tenon::Simulator simulator(plant.builder.Build(), tenon::RecommendedOptions(plant.robot.world));
    apart = Run(simulator, plant.robot.world.state, plant.robot.from_controller.y, end);
  });
  tenon::DiagramBuilder builder;
  auto& walk = builder.Add<tenon::QuadrupedWalk>("loop", TrotParams());
  tenon::Simulator simulator(builder.Build(), tenon::RecommendedOptions(walk));
  const bool same = Run(simulator, walk.world.state, walk.locomotion.torque, end) == apart;
  const auto& state = simulator.context().Eval(walk.world.state);
  std::printf("t = %g s: the trunk is at x = %.3f m, z = %.3f m, %s\n", end, state.p_WB[0], state.p_WB[2],
              same ? "bit for bit as in one program" : "NOT as in one program");
  return same && ended ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) try {
  const std::string part = argc > 1 ? argv[1] : "";
  if (part.empty()) return Compare(3);
  const double end = argc > 2 ? std::atof(argv[2]) : 60;
  if (part == "controller") {
    Controller({}).Run(end);
  } else if (part == "plant") {
    RunByTheClock({}, end);
  } else if (part == "real-time") {
    return WithController(OwnLink(), end, [&] { RunByTheClock(OwnLink(), end); }) ? 0 : 1;
  } else {
    std::fprintf(stderr, "walk_apart [controller | plant | real-time] [seconds]\n");
    return 2;
  }
} catch (const std::exception& error) {
  std::fprintf(stderr, "walk_apart: %s\n", error.what());
  return 1;
}
