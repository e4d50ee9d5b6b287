#pragma once

#include <tenon/apps/common/customisation.h>
#include <tenon/apps/common/scenario_app.h>
#include <tenon/apps/quadruped/quadruped_scenario.h>
#include <tenon/apps/quadruped/wire_recorder.h>

namespace tenon::apps {

/// The keys of a scenario that name shipped files, and the kinds of these files.
std::vector<ScenarioFile> LeggedFiles();

/// Throws KeyError if a scenario chooses a shipped observer, but a customisation has replaced it.
void CheckObserver(const std::optional<ObserverKind>& observer, const QuadrupedWalk& loop);

/// Checks whether a scenario can be run, without running it. Throws KeyError.
void CheckQuadruped(const QuadrupedScenario& scenario, const Customisation<QuadrupedWalk>& customisation);

/// Runs one scenario, in the diagram of a walk that `customisation` changes. With a wire, a standing
/// robot is served in real time, see Serve. Throws KeyError and the errors of the outputs.
RunResult RunQuadruped(const QuadrupedScenario& scenario, const RunOptions& options,
                       const Customisation<QuadrupedWalk>& customisation = {}, const Wire& wire = {});

/// Demands that a walk to its end covers `commanded` [m] within the tolerance of its path, if it is to
/// arrive.
void JudgeArrival(const QuadrupedScenario& scenario, double commanded, Summary& summary);

/// Sets the mode of a supervisor at the end, what damped the joints, and when.
void SetDeployment(const DeploymentStatus& status, Summary& summary);

/// Returns LINK, "interface[,domain]", of "unitree[:LINK]", the value of --serve and --drive; "lo" by
/// default. Throws ParameterError for another robot.
std::string UnitreeLink(const char* option, const std::string& where);

/// The option --serve: a client on DDS commands the joints of a standing robot in place of its PD control.
/// The domain of "lo" is 1 by default, as in the maker's simulator.
/// Another interface has domain 0, as the robots do. The run is recorded in `out`, or repeated without DDS,
/// see Wire. Throws ParameterError, also in a build without Cyclone DDS.
struct Served {
  std::function<void(Simulator&)> log;                      ///< to be called before the run
  std::function<void(Summary&, const Simulator&)> figures;  ///< adds numbers of commands and of late ticks
};
Served Serve(const Wire& wire, DiagramBuilder& builder, QuadrupedStand& loop,
             const std::filesystem::path& out);

/// The option --drive: the scenario's controller walks a robot on DDS, in real time
/// and under a supervisor. However the run ends, its last commands damp the joints. Throws as Serve does.
RunResult Drive(const Wire& wire, QuadrupedScenario scenario, RunOptions options);

/// Returns the link to the robot that a scenario drives: that of the option, else the `link` of its
/// robot; empty if the robot is simulated. Changes the scenario to one that Drive needs: `link` set, a Go2 in
/// place of DogBot, the state estimated, no foot sensors, and by default a supervisor that lets a lying robot
/// stand up, walk and lie down. Throws ParameterError for a scenario that stands.
std::string SetDriven(const std::string& name, const std::string& option, YamlDocument& document);

}  // namespace tenon::apps
