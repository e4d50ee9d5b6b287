#pragma once

#include <tenon/apps/common/blame.h>
#include <tenon/apps/common/run_scenario.h>
#include <tenon/apps/common/scenario_app.h>
#include <tenon/apps/quadruped/quadruped_scenario.h>

#include <string>

namespace tenon::apps {

/// From which keys of a scenario the blocks of legged robots are made.
inline constexpr KeyOfBlock kKeysOfLegged[] = {
    {"plant", "robot"},
    {"monitor", "fall"},
    {"walk", "walk.path"},
    {"scheduler", "walk.gaits"},
    {"com_planner", "walk.zmp"},
    {"swing_planner", "walk.step"},
    {"locomotion", "profile"},
    {"observer", "profile"},
    {"pd", "pd"},
    {"sliding_load", "payload"},
    {"disturbances", "forces"},
    {"encoders", "hardware"},
    {"torque_sensor", "hardware"},
    {"foot_sensor", "hardware"},
    {"imu", "hardware"},
    {"imu_errors", "hardware"},
    {"drive_lag", "hardware"},
    {"drive_errors", "hardware"},
    {"command_delay", "hardware"},
    {"estimator", "walk.state"},
    {"obstacles", "surroundings"},
    {"person", "person"},
    {"leash", "leash"},
    {"supervisor", "supervisor"},
    {"admittance", "admittance"},
};

/// One line: robot, time, seed.
std::string Describe(const QuadrupedScenario& scenario);
/// Runs one scenario; throws KeyError and what the outputs throw.
RunResult RunQuadruped(const QuadrupedScenario& scenario, const RunOptions& options);
/// tenon-quadruped, for campaigns. A scenario with a sweep is refused: it is a campaign itself.
ScenarioApp QuadrupedApp();

}  // namespace tenon::apps
