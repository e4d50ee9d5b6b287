#pragma once

#include <tenon/systems/geometry.h>
#include <tenon/systems/live/live_recording.h>
#include <tenon/systems/report/report.h>
#include <tenon/systems/simulation/simulator.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace tenon {

/// What a command sets; it is made by the thread of the run, between two ticks.
using LiveSets = std::vector<LiveSet>;

/// What a browser can do to a run beyond setting its Parameters. Each says what a command sets: Parameters
/// and states, by their paths. What is empty cannot be done. A function refuses by throwing ParameterError.
struct LiveControls {
  struct Drive {
    std::array<double, 2> forward{}, sideways{}, yaw{};  ///< least and largest [m/s], [m/s], [rad/s]
    std::function<LiveSets(const Vec<3>& velocity)> set{};
  };
  struct Choice {
    std::vector<std::string> names{};
    std::function<LiveSets(std::size_t index)> set{};
  };
  struct Goal {
    std::string name{};             ///< of what is dragged
    std::array<Vec<3>, 2> box_W{};  ///< within which it can be dragged: lowest and highest corner [m]
    std::function<LiveSets(Context& context, const Vec<3>& position_W)> set{};
  };
  struct Pull {
    double stiffness = 0, max_force = 0;          ///< [N/m], [N]
    std::map<std::size_t, std::string> bodies{};  ///< what can be pulled: indices among all shapes, and names
    /// `first` is the call that fixes the point on the body.
    std::function<LiveSets(Context& context, std::size_t shape, const Vec<3>& point_W, const Vec<3>& target_W,
                           bool first)>
        set;
    std::function<LiveSets()> release{};
    /// The point and the force on it, for the view [m], [N].
    std::function<std::pair<Vec<3>, Vec<3>>(Context& context)> state{};
  };
  struct Load {
    std::string name{};
    std::array<double, 2> mass{};                                  ///< [kg]
    double start = 0;                                              ///< [kg]
    std::function<LiveSets(Context& context, double mass)> set{};  ///< 0: none
  };
  std::optional<Drive> drive;
  std::optional<Choice> gaits, postures;
  std::optional<Goal> goal;
  std::optional<Pull> pull;
  std::optional<Load> load;
};

/// What is shown of a run, and what can be done to it.
struct LiveView {
  std::vector<const Source*> signals;
  std::vector<const OutputPort<Geometry>*> shapes;
  LiveControls controls{};
  std::string title{}, description{};
  std::vector<Plot> plots{};
  std::vector<Band> bands{};
  std::vector<SignalLimits> limits{};
  /// The scenario that starts with the Parameters that were set; none: it cannot be saved.
  std::function<std::string(const LiveSets& parameters)> save{};
};

struct LiveOptions {
  std::string address = "127.0.0.1";  ///< on any other one the page asks for a token
  int port = 8080;                    ///< or, if it is taken, one of the next twenty; 0: any
  double history = 30;                ///< what is kept, and how far a run can be set back [s]
  double frame = 0.01;                ///< commands reach the run at multiples of this [s]
  Rate signal_rate = Hz(100);         ///< of what is sent
  Rate frame_rate = Hz(50);           ///< of the shapes
  double rate = 1;                    ///< of the run's time to the clock's, at first; 0: as fast as it can
  std::filesystem::path recording{};  ///< file for all that comes from outside; empty: none
  /// Asked some twenty times a second at least, in the thread of the run: true ends it.
  std::function<bool()> stop{};
  bool returns_for_reset = false;  ///< a reset ends Run, see reset_seed; else the run begins anew inside
};

/// How a live run goes, for a line of status.
struct LiveStatus {
  double time = 0;  ///< [s]
  std::string state;
  double rate = 0;  ///< of the run's time to the clock's, in the last second
  std::size_t clients = 0;
  long refused = 0;  ///< requests
};

/// A page in the browser that shows a run while it goes on, and steers it: drive, push, tune, pause, go back.
///
///     LiveServer live;
///     std::cout << live.url() << std::endl;
///     live.Run(simulator, {.signals = {&cart.state}, .shapes = {&cart.geometry}});
///
/// The run keeps to the clock. What a browser asks for happens between two ticks, by setting Parameters and
/// states; it is recorded and can be replayed (live_recording.h), and nothing else of the browsers reaches
/// the run: with any number of them, slow ones and dead ones, it is the same run, bit for bit. One of them
/// drives at a time. The page is that of Report; no other origin may send commands.
class LiveServer {
 public:
  /// Listens. Throws OutputError if no port is free or the page's libraries are not installed.
  explicit LiveServer(LiveOptions options = {});
  ~LiveServer();
  LiveServer(const LiveServer&) = delete;
  LiveServer& operator=(const LiveServer&) = delete;

  /// With the token, if there is one.
  const std::string& url() const;
  int port() const;

  /// Runs until `duration` [s], or until it is stopped. A run that a monitor ends stands still while somebody
  /// looks at it, and can be set back. Throws what Simulator::AdvanceTo throws if nobody looks.
  RunStatus Run(Simulator& simulator, const LiveView& view, std::optional<double> duration = {});
  /// Why Run returned, if for a reset: the seed of the run to come.
  std::optional<std::uint64_t> reset_seed() const;
  LiveOptions& options();

  /// In the thread of the run, from LiveOptions::stop: a command as a browser gives it, as JSON. Returns the
  /// answer.
  std::string Command(const std::string& client, const std::string& json);
  LiveStatus status() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tenon
