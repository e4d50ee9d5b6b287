#pragma once

#include <tenon/apps/common/customisation.h>
#include <tenon/apps/common/ros2_outputs.h>
#include <tenon/apps/quadruped/quadruped_scenario.h>
#include <tenon/controllers/legged/planning/walk_drive.h>
#include <tenon/plants/legged/spring_pull.h>

namespace tenon::apps {

/// A robot or client on the wire, or the directory of a run with one, which is repeated without it.
struct Wire {
  std::string where = {};             ///< "INTERFACE[,DOMAIN]"; empty: none
  std::filesystem::path replay = {};  ///< empty: no replay
  bool changed = false;               ///< the replay has another scenario than the run
  bool any() const { return !where.empty() || !replay.empty(); }
};

/// The values that a run received over a wire: rows of a time, the elements of the received signal, the age
/// of the plan if it is calculated in a thread (see Slow), and the checksum of the message that was sent at
/// this tick.
struct WireRows {
  std::size_t columns = 0;
  bool ages = false;
  std::vector<double> numbers = {};

  std::size_t rows() const { return numbers.size() / columns; }
  const double* row(std::size_t i) const { return &numbers[i * columns]; }
  double end() const { return row(rows() - 1)[0]; }  ///< [s]
};

/// Reads wire.bin of a directory: a line of names, then rows of doubles. A last row that is not whole, as
/// after a kill, is dropped. Throws ParameterError for a file that cannot be read or whose columns without
/// ages are not `columns`.
WireRows ReadWire(const std::filesystem::path& directory, std::size_t columns);

/// Writes the wire.bin of a run, or compares a replay with that of its run.
class WireRecorder {
 public:
  /// `out` is the directory of the run, which is created; if empty, nothing is written.
  WireRecorder(Wire wire, std::filesystem::path out);

  /// The values that were received, for the block that repeats them; empty unless this is a replay.
  template <class T>
  Recording<T> Received(const T& initial) {
    Recording<T> recording;
    if (wire_.replay.empty()) return recording;
    recorded_ = ReadWire(wire_.replay, 2 + internal::CountScalars(internal::TypeInfoOf<T>(), &initial));
    recording.resize(recorded_.rows(), {0, initial});
    for (std::size_t i = 0; i < recorded_.rows(); ++i) {
      recording[i].time = recorded_.row(i)[0];
      internal::FromDoubles(internal::TypeInfoOf<T>(), &recording[i].value, recorded_.row(i) + 1);
    }
    return recording;
  }
  const WireRows& recorded() const { return recorded_; }
  /// The durations of the calculations by their starts, which are ticks of the wire; empty without ages.
  Recording<double> Durations(Rate rate) const;

  /// Logs the signals of a row at the rate of the wire.
  void AddTo(Simulator& simulator, Rate rate, const std::vector<const Source*>& signals);
  /// Adds the numbers of equal and of other checksums of a replay, and when the first one differed.
  void AddTo(Summary& summary) const;

 private:
  class Check;
  Wire wire_;
  std::filesystem::path out_;
  WireRows recorded_;
  std::shared_ptr<Check> check_;
};

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

/// The blocks that a live run of a quadruped adds: `live_drive`, which overrides the command of its walk,
/// `live_pull`, a spring that pulls a body, and `live_load`, a load that can be placed on the trunk.
class QuadrupedLive {
 public:
  /// Inserts the blocks before the diagram is built; `walk` is null for a robot that stands. Throws
  /// ParameterError if the scenario has so many forces that those of pull and load cannot be added.
  QuadrupedLive(DiagramBuilder& builder, QuadrupedWorld& world, WalkSchedule* walk,
                const LiveScenario& limits);

  /// Adds the signals to log and the shapes to show. The first entry of `shapes` must be those of the plant.
  void AddTo(std::vector<const Source*>& signals, std::vector<const OutputPort<Geometry>*>& shapes) const;
  LiveControls Controls() const;
  WalkDrive* drive() const { return drive_; }  ///< null for a robot that stands

 private:
  LiveScenario limits_;
  QuadrupedWorld& world_;
  WalkDrive* drive_ = nullptr;
  SpringPull& pull_;
  SlidingLoad& load_;
  bool acts_ = false;  ///< the plant takes forces
};

/// Sends and records the messages of a walk, see QuadrupedMessages, and lets /cmd_vel or /joy command its
/// velocity in the range of a live run. `drive` is that of a live run, or null. Joints, IMU and foot forces
/// are recorded at the rates of their sensors. For a robot, `wire` has the rate of its sensors and the epoch
/// that is added to the stamps; without it, /clock has the time of the run, and /ground_truth the true state
/// of a run with an estimator. Adds nothing if nobody wants messages. Throws KeyError of `robot`.
struct RobotTimes {
  Rate rate;
  double epoch = 0;  ///< [s]
};
void AddRos2(DiagramBuilder& builder, Ros2Outputs& outputs, const LeggedScenario& scenario,
             QuadrupedWalk& walk, WalkDrive* drive, const std::optional<RobotTimes>& wire = {});
void AddRos2(DiagramBuilder& builder, Ros2Outputs& outputs, const LeggedScenario& scenario,
             QuadrupedStand& stand, WalkDrive* drive = nullptr);

}  // namespace tenon::apps
