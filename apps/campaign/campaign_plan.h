#pragma once

#include <tenon/apps/campaign/campaign_file.h>

#include <functional>

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

}  // namespace tenon::apps
