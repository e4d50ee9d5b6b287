#pragma once

#include <tenon/apps/campaign/campaign_file.h>
#include <tenon/systems/campaign/statistics.h>

#include <functional>
#include <unordered_map>
#include <unordered_set>

namespace tenon::apps {

/// The seed, scenario and settings of a run, which depend only on its index.
struct RunSetup {
  std::uint64_t seed = 1;
  std::string scenario;
  std::vector<std::pair<std::string, std::string>> settings;  ///< dotted keys and YAML, for YamlDocument::Set
  std::vector<std::pair<std::string, std::string>> varied;    ///< columns of runs.csv
};

/// The points of a campaign, the seeds at each point and the numbering of runs. It is immutable and
/// thread-safe.
///
/// A run has the index (point levels + level) seeds + k, where k counts the seeds. The level identifies a
/// value of the bisection by its position in the binary tree of intervals, numbered as in a heap from 0; it
/// is 0 without bisection.
class CampaignPlan {
 public:
  /// Values of the keys of a search, by their names in the file.
  using Chosen = std::map<std::string, double>;

  /// Reads `file`. All runs have the values `chosen`. Throws ParameterError with file, line and key.
  explicit CampaignPlan(const YamlDocument& file, Chosen chosen = {}, std::optional<SeedRange> seeds = {});
  CampaignPlan(const CampaignPlan&) = delete;
  CampaignPlan& operator=(const CampaignPlan&) = delete;

  const CampaignFile& file() const { return file_; }
  std::size_t num_points() const { return points_; }
  std::size_t num_seeds() const { return file_.seeds.count; }
  std::size_t size() const { return points_ * levels_ * num_seeds(); }

  RunSetup Setup(std::size_t run) const;
  std::size_t PointOf(std::size_t run) const { return run / num_seeds() / levels_; }
  std::size_t LevelOf(std::size_t run) const { return run / num_seeds() % levels_; }
  std::size_t RunOf(std::size_t point, std::size_t level, std::size_t k) const {
    return (point * levels_ + level) * num_seeds() + k;
  }
  /// Returns all scenarios that can occur.
  std::vector<std::string> Scenarios() const;
  /// Returns the values of the grids, lists and choices at a point by name.
  std::vector<std::pair<std::string, std::string>> AtPoint(std::size_t point) const;
  /// Returns the value of the limit's key at a level.
  double LevelValue(std::size_t level) const;
  /// Returns the indices of the axes' labels at a point.
  std::vector<std::size_t> LabelsAt(std::size_t point) const;

  struct Setting {
    std::string key, value;
  };
  /// One factor of the product of points.
  struct Axis {
    std::string name;
    std::vector<std::string> labels;
    std::vector<std::vector<Setting>> settings;  ///< settings of each label
  };
  const std::vector<Axis>& axes() const { return axes_; }

 private:
  /// A variation that draws one value for each seed.
  struct Drawn {
    std::string name;
    std::vector<std::pair<std::string, double>> sets;
    std::function<double(std::uint64_t seed, std::size_t k)> draw;
  };
  void AddAxis(const std::string& name, const Variation& how, const std::vector<std::string>& choices);
  void AddDrawn(const std::string& name, const Variation& how);

  CampaignFile file_;
  Chosen chosen_;
  std::vector<std::string> order_;  ///< keys of `vary` in the order of the file
  std::vector<Axis> axes_;
  std::vector<Drawn> drawn_;
  std::vector<std::string> sobol_;  ///< keys varied by the Sobol sequence
  std::vector<std::vector<double>> sobol_points_;
  std::size_t points_ = 1;
  std::size_t levels_ = 1;
};

/// Part `index` of `count` parts of a campaign, counted from 1. It consists of every `count`-th run.
struct Shard {
  std::size_t index = 1, count = 1;
  bool Has(std::size_t run) const { return run % count == index - 1; }
};

/// Selects the next run and decides when an estimate is precise enough. Decisions depend on results in the
/// order of the seeds, not in the order of completion, so that the same runs belong to the campaign for any
/// number of workers. When estimating, some runs are started that turn out to be unnecessary.
class CampaignSchedule {
 public:
  /// `ahead` limits the number of runs of one point that are started before it is known whether they are
  /// needed.
  CampaignSchedule(const CampaignPlan& plan, Shard shard, std::size_t ahead);

  /// Returns the next run to start; empty if all are started or done.
  std::optional<std::size_t> Next() { return adaptive() ? NextAdaptive() : NextFixed(); }
  /// Records the result of a run of this or an earlier process.
  void Done(std::size_t run, bool survived);
  /// Records that a started run has no result and is not run again. Returns whether the campaign can be
  /// finished without it.
  bool Lost(std::size_t run);
  bool finished() const { return adaptive() ? open_ == 0 : cursor_ >= plan_.size() && started_.empty(); }
  /// Returns whether a run belongs to the campaign. Valid once the schedule is finished.
  bool Counts(std::size_t run) const;
  /// Returns the number of runs of this part, if it is known in advance.
  std::optional<std::size_t> total() const;

  /// The limit found at a point: the largest value that was survived and the smallest that was not.
  struct Limit {
    double survives = 0, fails = 0;
  };
  Limit LimitAt(std::size_t point) const { return sequences_[point].limit; }

 private:
  /// The state of a point, whose seeds are judged in order at one value.
  struct Sequence {
    std::size_t level = 0;
    std::size_t judged = 0;    ///< number of judged seeds
    std::size_t survived = 0;  ///< number of survivors among them
    std::size_t next = 0;      ///< seed to start
    bool over = false;         ///< the point is decided
    int steps = 0;             ///< completed bisection steps
    Limit limit{};
  };
  bool adaptive() const { return plan_.file().limit || plan_.file().estimate == Estimate::kSurvival; }
  void Judge(std::size_t point);
  bool Decided(const Sequence& at) const;
  std::optional<std::size_t> NextFixed();
  std::optional<std::size_t> NextAdaptive();

  const CampaignPlan& plan_;
  Shard shard_;
  std::size_t ahead_;
  std::unordered_set<std::size_t> started_;  ///< started and not done
  // Used without an estimate.
  std::vector<bool> done_;
  std::size_t cursor_ = 0;
  // Used with an estimate.
  std::vector<Sequence> sequences_;  ///< by point
  std::size_t turn_ = 0;             ///< the point that is tried next
  std::size_t open_ = 0;             ///< number of undecided points
  std::unordered_map<std::size_t, bool> known_;
  std::map<std::pair<std::size_t, std::size_t>, std::size_t>
      counted_;  ///< number of seeds that belong to the campaign, by point and level
};

}  // namespace tenon::apps
