#pragma once

#include <tenon/systems/live/live_recording.h>
#include <tenon/systems/report/report.h>

namespace tenon {

/// The values that a command sets. The thread of the run computes them between two ticks.
using LiveSets = std::vector<LiveSet>;

/// Controls of a run beyond its Parameters. Each control returns the Parameters and states that a command
/// sets, by their paths. Empty controls are not available. A function refuses a command by throwing
/// ParameterError.
struct LiveControls {
  struct Drive {
    std::array<double, 2> forward{}, sideways{}, yaw{};  ///< lower and upper limits [m/s], [m/s], [rad/s]
    std::function<LiveSets(const Vec<3>& velocity)> set{};
  };
  struct Choice {
    std::vector<std::string> names{};
    std::function<LiveSets(std::size_t index)> set{};
  };
  struct Goal {
    std::string name{};             ///< name of the dragged object
    std::array<Vec<3>, 2> box_W{};  ///< lower and upper corner of the region of the goal [m]
    std::function<LiveSets(Context& context, const Vec<3>& position_W)> set{};
  };
  struct Pull {
    double stiffness = 0, max_force = 0;  ///< [N/m], [N]
    std::map<std::size_t, std::string>
        bodies{};  ///< bodies that can be pulled: indices of their shapes, and names
    /// `first` is true in the call that determines the point on the body.
    std::function<LiveSets(Context& context, std::size_t shape, const Vec<3>& point_W, const Vec<3>& target_W,
                           bool first)>
        set;
    std::function<LiveSets()> release{};
    /// Returns the point and the force on it for display [m], [N].
    std::function<std::pair<Vec<3>, Vec<3>>(Context& context)> state{};
  };
  struct Load {
    std::string name{};
    std::array<double, 2> mass{};                                  ///< lower and upper limits [kg]
    double start = 0;                                              ///< initial mass [kg]
    std::function<LiveSets(Context& context, double mass)> set{};  ///< mass 0 removes the load
  };
  std::optional<Drive> drive;
  std::optional<Choice> gaits, postures;
  std::optional<Goal> goal;
  std::optional<Pull> pull;
  std::optional<Load> load;
};

/// The displayed signals and the controls of a run.
struct LiveView {
  std::vector<const Source*> signals;
  std::vector<const OutputPort<Geometry>*> shapes;
  LiveControls controls{};
  std::string title{}, description{};
  std::vector<Plot> plots{};
  std::vector<Band> bands{};
  std::vector<SignalLimits> limits{};
  /// Returns a scenario that starts with the given values; empty if the run cannot be saved.
  std::function<std::string(const LiveSets& parameters)> save{};
};

struct LiveOptions {
  std::string address = "127.0.0.1";  ///< bound address; others than the default need a token
  int port = 8080;                    ///< if it is in use, one of the next twenty; 0: any port
  double history = 30;                ///< length of the history to which a run can be set back [s]
  double frame = 0.01;                ///< commands reach the run at multiples of this [s]
  Rate signal_rate = Hz(100);         ///< rate of transmitted signals
  Rate frame_rate = Hz(50);           ///< rate of transmitted shapes
  double rate = 1;                    ///< initial real-time factor; 0: as fast as possible
  std::filesystem::path recording{};  ///< file for the recording; empty: none
  /// Called by the thread of the run at least twenty times a second; returning true ends the run.
  std::function<bool()> stop{};
  bool returns_for_reset = false;  ///< whether a reset ends Run (see reset_seed) or restarts the run inside
};

/// The status of a live run.
struct LiveStatus {
  double time = 0;  ///< [s]
  std::string state;
  double rate = 0;  ///< real-time factor in the last second
  std::size_t clients = 0;
  long refused = 0;  ///< number of refused requests
};

/// Serves a page that shows a run in the browser and steers it: drive, push, tune, pause, go back.
///
///     LiveServer live;
///     std::cout << live.url() << std::endl;
///     live.Run(simulator, {.signals = {&cart.state}, .shapes = {&cart.geometry}});
///
/// The run is synchronised to wall-clock time. Commands of browsers set Parameters and states between two
/// ticks; they are recorded and can be replayed (live_recording.h). Browsers have no other influence: the run
/// is the same, bit for bit, for any number of browsers and however slow they are. One browser drives at a
/// time. The page is that of Report; pages of other origins cannot send commands.
class LiveServer {
 public:
  /// Starts listening. Throws OutputError if no port is free or the page's libraries are not installed.
  explicit LiveServer(LiveOptions options = {});
  ~LiveServer();
  LiveServer(const LiveServer&) = delete;
  LiveServer& operator=(const LiveServer&) = delete;

  /// Address of the page, with the token if there is one.
  const std::string& url() const;
  int port() const;

  /// Runs until `duration` [s] or until it is stopped. A run that a monitor or an error ends waits while
  /// browsers are connected, and can be set back. Without browsers, throws as Simulator::AdvanceTo does.
  RunStatus Run(Simulator& simulator, const LiveView& view, std::optional<double> duration = {});
  /// The seed of the next run, if Run returned because of a reset.
  std::optional<std::uint64_t> reset_seed() const;
  LiveOptions& options();

  /// Executes a command in JSON as if it came from a browser and returns the answer. Call it from
  /// LiveOptions::stop.
  std::string Command(const std::string& client, const std::string& json);
  LiveStatus status() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tenon
