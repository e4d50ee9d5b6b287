#pragma once

#include <tenon/systems/framework/block/distribution.h>
#include <tenon/systems/framework/types/fields.h>
#include <tenon/systems/yaml/yaml.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace tenon::apps {

/// How one key of the scenarios varies over a campaign, in one of these ways. Grids, lists and choices
/// multiply with each other; the others draw one value for each seed.
struct Variation {
  std::vector<double> grid;                       ///< of these numbers
  std::optional<std::array<double, 3>> linspace;  ///< a grid: from, to, count
  std::vector<YamlText> list;                     ///< of any values
  /// Names, each with the keys that it sets.
  std::map<std::string, std::map<std::string, YamlText>> choices;
  std::optional<std::array<double, 2>> uniform;          ///< low, high
  std::optional<std::array<double, 2>> normal;           ///< mean, standard deviation
  std::optional<std::array<double, 2>> lognormal;        ///< those of the logarithm
  std::optional<std::array<double, 2>> sobol;            ///< low, high; all such keys fill one space
  std::optional<std::array<double, 2>> latin_hypercube;  ///< low, high; likewise
  /// The keys that it sets, each to the value times a factor; empty: the one by whose name it goes.
  std::map<std::string, double> sets;

  static FieldList Fields();
  void Validate() const;  ///< throws ParameterError

  /// Multiplies the runs, instead of drawing one value for each seed.
  bool multiplies() const { return !grid.empty() || linspace || !list.empty() || !choices.empty(); }
  /// The one that is given, of uniform, normal and lognormal; or none.
  std::optional<Distribution> distribution() const;
};

struct SeedRange {
  std::uint64_t first = 1;  ///< the seed of the first run
  std::size_t count = 1;    ///< so many runs, each with the next seed

  static FieldList Fields() { return {{"first", &SeedRange::first}, {"count", &SeedRange::count}}; }
  void Validate() const;  ///< throws ParameterError
};

/// The largest value of a key with which a run survives with a probability, by bisection: at each value runs
/// seed after seed; after 8, 16, 32, … of them it is decided if Wilson's interval lies on one side of the
/// probability, with the confidence shared among these looks (Bonferroni); when the seeds are used up, by the
/// share that survived.
struct LimitSearch {
  std::string key;                     ///< or a name for what `sets` says
  std::map<std::string, double> sets;  ///< as in Variation
  double from = 0;                     ///< taken to be survived
  double to = 0;                       ///< taken to be not
  int steps = 6;                       ///< of the bisection
  double probability = 0.9;            ///< with which a run is to survive

  static FieldList Fields() {
    return {Required("key", &LimitSearch::key), {"sets", &LimitSearch::sets},
            {"from", &LimitSearch::from},       Required("to", &LimitSearch::to),
            {"steps", &LimitSearch::steps},     {"probability", &LimitSearch::probability}};
  }
  void Validate() const;  ///< throws ParameterError
};

/// Until when a campaign goes on: through all its runs, or until it knows.
enum class Estimate { kAll, kSurvival };
constexpr auto EnumNames(Estimate) {
  return std::array{Named{Estimate::kAll, "all"}, Named{Estimate::kSurvival, "survival"}};
}

/// A campaign as its file says it.
struct CampaignFile {
  std::string app;                        ///< whose scenarios run
  std::string scenario;                   ///< a shipped scenario or a YAML file
  std::string description;                ///< one line
  std::optional<double> duration_s;       ///< of each run, instead of the scenario's
  SeedRange seeds;                        ///< of each point; with `estimate` and `limit` at most
  std::map<std::string, YamlText> set;    ///< in all scenarios
  std::map<std::string, Variation> vary;  ///< a key of the scenario, or `scenario` itself
  std::optional<double> wall_limit_s;     ///< a run that takes longer on the clock is ended, and has failed
  Estimate estimate = Estimate::kAll;     ///< survival: until Wilson's interval is as narrow as asked
  double interval_width = 0.1;            ///< of that
  double confidence = 0.95;               ///< of all intervals
  std::optional<LimitSearch> limit;
  std::string worst_by;  ///< the figure whose largest values are worth a look; empty: the first error

  static FieldList Fields();
  void Validate() const;  ///< throws ParameterError
};

}  // namespace tenon::apps
