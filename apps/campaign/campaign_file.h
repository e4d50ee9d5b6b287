#pragma once

#include <tenon/systems/framework/block/distribution.h>
#include <tenon/systems/yaml/yaml.h>

namespace tenon::apps {

/// The variation of one key of the scenarios in a campaign, in exactly one of these ways. Grids, lists and
/// choices span a product of points; the others draw one value for each seed.
struct Variation {
  std::vector<double> grid;                       ///< numbers of the grid
  std::optional<std::array<double, 3>> linspace;  ///< evenly spaced grid: first, last, number of values
  std::vector<YamlText> list;                     ///< list of values of any type
  /// Names and the keys that each of them sets.
  std::map<std::string, std::map<std::string, YamlText>> choices;
  std::optional<std::array<double, 2>> uniform;  ///< uniform distribution: minimum, maximum
  std::optional<std::array<double, 2>> normal;   ///< normal distribution: mean, standard deviation
  /// Lognormal distribution: mean, standard deviation of the logarithm.
  std::optional<std::array<double, 2>> lognormal;
  std::optional<std::array<double, 2>> sobol;  ///< minimum, maximum; all such keys share one Sobol sequence
  /// Keys that are set to the value times a factor; empty: the key of the variation itself.
  std::map<std::string, double> sets;

  static FieldList Fields() {
    return {{"grid", &Variation::grid},
            {"linspace", &Variation::linspace},
            {"list", &Variation::list},
            {"choices", &Variation::choices},
            {"uniform", &Variation::uniform},
            {"normal", &Variation::normal},
            {"lognormal", &Variation::lognormal},
            {"sobol", &Variation::sobol},
            {"sets", &Variation::sets}};
  }
  void Validate() const;  ///< throws ParameterError

  /// Returns whether the variation multiplies the points instead of drawing one value for each seed.
  bool multiplies() const { return !grid.empty() || linspace || !list.empty() || !choices.empty(); }
  /// Returns the distribution if `uniform`, `normal` or `lognormal` is given.
  std::optional<Distribution> distribution() const;
};

struct SeedRange {
  std::uint64_t first = 1;  ///< seed of the first run
  std::size_t count = 1;    ///< number of runs with consecutive seeds

  static FieldList Fields() {
    return {{"first", &SeedRange::first}, Field("count", &SeedRange::count).Between(1, 10'000'000)};
  }
  void Validate() const;  ///< throws ParameterError
};

/// Search by bisection for the largest value of a key at which a run survives with a given probability. At
/// each value, runs are made with one seed after the other. After 8, 16, 32, … runs, the value is decided if
/// Wilson's interval lies on one side of the probability, with the confidence divided among these tests
/// (Bonferroni). If all seeds are used, the share of survivors decides.
struct LimitSearch {
  std::string key;                     ///< varied key, or any name if `sets` is given
  std::map<std::string, double> sets;  ///< keys that are set to the value times a factor; empty: `key`
  double from = 0;                     ///< value at which all runs are assumed to survive
  double to = 0;                       ///< value at which all runs are assumed to fail
  int steps = 6;                       ///< number of bisection steps
  double probability = 0.9;            ///< required probability of survival

  static FieldList Fields() {
    return {Required("key", &LimitSearch::key),
            {"sets", &LimitSearch::sets},
            {"from", &LimitSearch::from},
            Required("to", &LimitSearch::to),
            Field("steps", &LimitSearch::steps).Between(1, 20),
            Field("probability", &LimitSearch::probability).Above(0).Below(1)};
  }
  void Validate() const;  ///< throws ParameterError
};

/// A key that a search varies between two bounds.
struct SearchedKey {
  double from = 0, to = 0;      ///< bounds
  std::optional<double> start;  ///< first value; empty: the middle of the bounds
  bool logarithmic = false;     ///< the search divides the range by ratios instead of differences
  /// Keys that are set to the value times a factor; empty: the key itself.
  std::map<std::string, double> sets;

  static FieldList Fields() {
    return {Required("from", &SearchedKey::from),
            Required("to", &SearchedKey::to),
            {"start", &SearchedKey::start},
            {"logarithmic", &SearchedKey::logarithmic},
            {"sets", &SearchedKey::sets}};
  }
  void Validate() const;  ///< throws ParameterError
};

/// Search for the values of keys at which a campaign costs least. The cost of values is the mean over all
/// runs of the campaign, of its points and seeds, of the weighted sum of `minimise`.
struct Optimisation {
  std::map<std::string, SearchedKey> vary;   ///< keys of the search, or any names with `sets`
  std::map<std::string, double> minimise;    ///< weights of figures
  std::map<std::string, double> subject_to;  ///< upper bounds of the means of figures over finished runs
  double failed_run_cost = 0;  ///< cost of a run that does not finish or lacks a figure of `minimise`
  int evaluations = 60;        ///< number of values that are tried
  /// Seeds on which the best and the first values are compared at the end.
  std::optional<SeedRange> held_back;

  static FieldList Fields() {
    return {Required("vary", &Optimisation::vary),
            Required("minimise", &Optimisation::minimise),
            {"subject_to", &Optimisation::subject_to},
            Required("failed_run_cost", &Optimisation::failed_run_cost),
            Field("evaluations", &Optimisation::evaluations).Between(1, 100'000),
            {"held_back", &Optimisation::held_back}};
  }
  void Validate() const;  ///< throws ParameterError
};

/// A bound of a quantile of a figure over all runs of a campaign. A run that does not finish or lacks the
/// figure counts as beyond any bound, and the worst value counts if a figure has several, such as one for
/// each leg.
struct QuantileGoal {
  std::string figure;              ///< name of the figure in the table of the runs
  double quantile = 0.99;          ///< share of the runs that must keep the bound
  std::optional<double> at_most;   ///< upper bound; empty: none
  std::optional<double> at_least;  ///< lower bound; empty: none

  static FieldList Fields() {
    return {Required("figure", &QuantileGoal::figure),
            Field("quantile", &QuantileGoal::quantile).Above(0).Below(1),
            {"at_most", &QuantileGoal::at_most},
            {"at_least", &QuantileGoal::at_least}};
  }
  void Validate() const;  ///< throws ParameterError
};

/// Termination of a campaign: after all runs, or when the probability of survival is known.
enum class Estimate { kAll, kSurvival };

/// The file of a campaign.
struct CampaignFile {
  std::string app;                      ///< name of the app that runs the scenarios
  std::string scenario;                 ///< a shipped scenario or a YAML file
  std::string description;              ///< description of the campaign in one line
  std::optional<double> duration_s;     ///< duration of each run; empty: the scenario's duration
  SeedRange seeds;                      ///< seeds at each point; the maximum with `estimate` or `limit`
  std::map<std::string, YamlText> set;  ///< values set in all scenarios, by key
  /// Variations by key of the scenario; the key `scenario` varies the scenario itself.
  std::map<std::string, Variation> vary;
  std::optional<double> wall_limit_s;  ///< maximum wall-clock time of a run; a longer run counts as failed
  /// Seeds of each point: all, or, with `survival`, until Wilson's interval is narrower than
  /// `interval_width`.
  Estimate estimate = Estimate::kAll;
  double interval_width = 0.1;  ///< width of Wilson's interval below which a point needs no more runs
  double confidence = 0.95;     ///< confidence of all intervals
  std::optional<LimitSearch> limit;
  std::optional<Optimisation>
      optimise;                     ///< instead of one campaign, a search with one for each trial of values
  std::vector<QuantileGoal> goals;  ///< goals that summary.json and the terminal judge
  std::string worst_by;             ///< figure whose largest values are listed; default: the first error

  static FieldList Fields() {
    return {Required("app", &CampaignFile::app),
            Required("scenario", &CampaignFile::scenario),
            {"description", &CampaignFile::description},
            Field("duration_s", &CampaignFile::duration_s).Positive(),
            {"seeds", &CampaignFile::seeds},
            {"set", &CampaignFile::set},
            {"vary", &CampaignFile::vary},
            Field("wall_limit_s", &CampaignFile::wall_limit_s).Positive(),
            {"estimate", &CampaignFile::estimate},
            Field("interval_width", &CampaignFile::interval_width).Between(1e-4, 1),
            Field("confidence", &CampaignFile::confidence).Above(0).Below(1),
            {"limit", &CampaignFile::limit},
            {"optimise", &CampaignFile::optimise},
            {"goals", &CampaignFile::goals},
            {"worst_by", &CampaignFile::worst_by}};
  }
  void Validate() const;  ///< throws ParameterError
};

}  // namespace tenon::apps
