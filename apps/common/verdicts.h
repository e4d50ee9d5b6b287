#pragma once

#include <tenon/apps/common/outputs.h>

namespace tenon::apps {

/// Decides whether a robot followed its path. The position may deviate by `tolerance` times the length of the
/// path, the heading by `tolerance` times half a turn. The position is not judged if the path has no length.
class PathVerdict {
 public:
  /// Constructs the verdict of a run without a path, which is not judged.
  PathVerdict() = default;
  /// `offset` and `turned`, the deviations at the start, increase the limits.
  PathVerdict(double tolerance, double length /* [m] */, double offset = 0 /* [m] */,
              double turned = 0 /* [rad] */);

  void Add(double time, double deviation /* [m] */, double turn /* [rad] */);
  /// Sets `followed` and the deviations with their limits. If the path was not followed, the run is not
  /// finished.
  void AddTo(Summary& summary) const;

 private:
  bool judged_ = false;
  std::optional<double> position_limit_, heading_limit_;  // [m], [rad]
  Tally deviations_, turns_;                              // [m], [rad]
  std::optional<double> left_, turned_;                   // times at which a limit was first exceeded [s]
};

/// Bounds of a figure in the task of a case, which must have a value between them.
struct TaskBounds {
  std::optional<double> at_least;  ///< lower bound; empty: none
  std::optional<double> at_most;   ///< upper bound; empty: none

  static FieldList Fields() {
    return {{"at_least", &TaskBounds::at_least}, {"at_most", &TaskBounds::at_most}};
  }
  void Validate() const;  ///< throws ParameterError
};

/// The task of a case: the figures of a run that is finished.
struct Task {
  std::map<std::string, TaskBounds> figures;  ///< bounds of figures of summary.json, by their dotted keys
  /// Time from which a run is judged by the task; empty: the end of the walk, or always without one.
  std::optional<double> due_s;

  static FieldList Fields() { return {{"figures", &Task::figures}, Field("due_s", &Task::due_s).AtLeast(0)}; }
  /// Sets the limits of the figures. A run without these figures is not finished, if it lasts until the task
  /// is due, by default at `due` [s]. Bounds of forces and of climb_m are multiplied by `weight` and
  /// `length`, for a scenario that is scaled to a robot. Throws KeyError, see Summary::Require.
  void AddTo(Summary& summary, double due = 0, double weight = 1, double length = 1) const;
};

/// Physically impossible events of a run; only the first event of each kind is kept.
class Breaches {
 public:
  /// Adds an event at `time` [s]. `what` describes where it happened and by how much.
  void Add(double time, const std::string& kind, const std::string& what) {
    first_.try_emplace(kind, time, kind + ": " + what);
  }
  void AddTo(Summary& summary) const {
    for (const auto& [kind, breach] : first_) summary.Break(breach.first, breach.second);
  }

 private:
  std::map<std::string, std::pair<double, std::string>> first_;
};

}  // namespace tenon::apps
