#include <tenon/apps/campaign/campaign_plan.h>
#include <tenon/systems/campaign/sampling.h>
#include <tenon/systems/text/text.h>

#include <fmt/core.h>

#include <algorithm>
#include <bit>
#include <set>

namespace tenon::apps {

namespace {

/// Returns the text of a YAML scalar.
std::string Unquoted(const std::string& yaml) {
  return YamlDocument::Parse("text: " + yaml, "scenario").Text("text");
}

/// Returns the keys that a value sets with their factors; by default its own key.
std::vector<std::pair<std::string, double>> Targets(const std::string& name,
                                                    const std::map<std::string, double>& sets) {
  if (sets.empty()) return {{name, 1}};
  return {sets.begin(), sets.end()};
}

std::string Text(double value) {
  return fmt::format("{}", value);
}

/// Throws ParameterError if a list contains a value twice, also in different notations such as 1 and 1.0.
void DemandNoneTwice(const std::vector<std::string>& labels) {
  std::set<std::string> seen;
  for (const std::string& label : labels) {
    const std::optional<double> number = internal::NumberIn<double>(label);
    if (!seen.insert(number ? Text(*number) : label).second)
      throw ParameterError(fmt::format("{} is given twice, and its runs would be the same: remove one",
                                       internal::Excerpt(label)));
  }
}

/// Throws ParameterError if `name` is the name of a column of results in runs.csv or, of a search, in
/// search.csv.
void DemandNoColumn(const std::string& name, bool searched = false) {
  std::vector<const char*> columns{"run", "seed", "case", "finished", "fell", "simulated_s", "end_reason"};
  if (searched) columns.insert(columns.end(), {"cost", "evaluation", "runs", "runs_finished"});
  for (const char* column : columns)
    if (name == column)
      throw ParameterError(fmt::format("'{}' is a result of runs and cannot be varied{}", name,
                                       name == "seed" ? "; use seeds: {first: 1, count: 20}" : ""));
}

/// Returns all keys of the scenario that a variation can set.
std::set<std::string> KeysOf(const std::string& name, const Variation& how) {
  std::set<std::string> keys;
  for (const auto& [label, settings] : how.choices)
    for (const auto& [key, value] : settings) keys.insert(key);
  if (how.choices.empty())
    for (const auto& [key, factor] : Targets(name, how.sets)) keys.insert(key);
  return keys;
}

double Between(const std::array<double, 2>& range, double share) {
  return range[0] + share * (range[1] - range[0]);
}

}  // namespace

void CampaignPlan::AddAxis(const std::string& name, const Variation& how,
                           const std::vector<std::string>& choices) {
  Axis axis{.name = name, .labels = {}, .settings = {}};
  std::vector<double> values = how.grid;
  if (how.linspace) {
    const auto [from, to, count] = *how.linspace;
    for (double i = 0; i < count;
         ++i)  // rounded, because labels show all digits: 0.05, not 0.049999999999999996
      values.push_back(std::stod(fmt::format("{:.12g}", from + (to - from) * i / (count - 1))));
  }
  for (const double value : values) {
    axis.labels.push_back(Text(value));
    std::vector<Setting>& settings = axis.settings.emplace_back();
    for (const auto& [key, factor] : Targets(name, how.sets)) settings.push_back({key, Text(value * factor)});
  }
  for (const YamlText& item : how.list) {
    axis.labels.push_back(Unquoted(item.text).empty() ? item.text : Unquoted(item.text));
    axis.settings.push_back({{name, item.text}});
  }
  for (const std::string& label : choices) {
    axis.labels.push_back(label);
    std::vector<Setting>& settings = axis.settings.emplace_back();
    for (const auto& [key, value] : how.choices.at(label)) settings.push_back({key, value.text});
  }
  DemandNoneTwice(axis.labels);
  points_ *= axis.labels.size();
  axes_.push_back(std::move(axis));
}

void CampaignPlan::AddDrawn(const std::string& name, const Variation& how) {
  Drawn drawn{.name = name, .sets = Targets(name, how.sets), .draw = {}};
  if (const auto distribution = how.distribution()) {
    drawn.draw = [name, distribution = *distribution](std::uint64_t seed, std::size_t) {
      RandomStream random(seed, name);
      return distribution.Draw(random);
    };
  } else {
    const std::size_t dimension = sobol_.size();
    sobol_.push_back(name);
    drawn.draw = [this, dimension, range = *how.sobol](std::uint64_t, std::size_t k) {
      return Between(range, sobol_points_[dimension][k]);
    };
  }
  drawn_.push_back(std::move(drawn));
}

CampaignPlan::CampaignPlan(const YamlDocument& document, Chosen chosen, std::optional<SeedRange> seeds)
    : file_(document.Read<CampaignFile>()), chosen_(std::move(chosen)), order_(document.Keys("vary")) {
  if (seeds) file_.seeds = *seeds;
  std::map<std::string, std::string> by_key;
  for (const std::string& name : order_) {
    const Variation& how = file_.vary.at(name);
    try {
      DemandNoColumn(name);
      if (how.multiplies()) {
        AddAxis(name, how, document.Keys("vary." + name + ".choices"));
      } else {
        AddDrawn(name, how);
      }
    } catch (const ParameterError& error) {
      throw ParameterError(fmt::format("{}: {}", document.PlaceOf("vary." + name), error.what()));
    }
    for (const std::string& key : KeysOf(name, how)) {
      const auto [other, added] = by_key.emplace(key, name);
      if (!added)
        throw ParameterError(fmt::format("{}: {} is already varied by {}; remove one of them",
                                         document.PlaceOf("vary." + name), key, other->second));
    }
    if (points_ > 10'000'000)
      throw ParameterError(
          fmt::format("{}: the product of all grids has more than 10 million points; draw some of the keys",
                      document.PlaceOf("vary." + name)));
  }
  const auto demand_free = [&](const std::string& place, const std::string& name,
                               const std::map<std::string, double>& sets) {
    try {
      DemandNoColumn(name, file_.optimise.has_value());
    } catch (const ParameterError& error) {
      throw ParameterError(fmt::format("{}: {}", document.PlaceOf(place), error.what()));
    }
    auto keys = Targets(name, sets);
    keys.emplace_back(name, 1);  // also a column of the table
    for (const auto& [key, factor] : keys) {
      if (by_key.contains(key) || file_.vary.contains(key) || file_.set.contains(key))
        throw ParameterError(
            fmt::format("{}: {} is also set or varied; remove it there", document.PlaceOf(place), key));
    }
    for (const auto& [key, factor] : keys) by_key.emplace(key, name);
  };
  if (file_.limit) demand_free("limit", file_.limit->key, file_.limit->sets);
  if (file_.optimise)
    for (const auto& [name, key] : file_.optimise->vary) demand_free("optimise.vary", name, key.sets);
  sobol_points_ = Sobol(num_seeds(), sobol_.size());
  if (file_.limit) levels_ = (std::size_t{1} << file_.limit->steps) - 1;
  if (static_cast<double>(points_) * static_cast<double>(levels_) * static_cast<double>(num_seeds()) >
      (file_.limit ? 1e15 : 1e9))
    throw ParameterError(
        fmt::format("{}: {} points, {} levels and {} seeds make too many runs; reduce one of them",
                    document.PlaceOf("seeds"), points_, levels_, num_seeds()));
}

std::vector<std::string> CampaignPlan::Scenarios() const {
  std::set<std::string> names;
  for (const Axis& axis : axes_)
    for (const std::vector<Setting>& settings : axis.settings)
      for (const Setting& setting : settings)
        if (setting.key == "scenario") names.insert(Unquoted(setting.value));
  const auto sets_it = [](const std::vector<Setting>& settings) {
    return std::ranges::count(settings, "scenario", &Setting::key) > 0;
  };
  if (!std::ranges::any_of(axes_,
                           [&](const Axis& axis) { return std::ranges::all_of(axis.settings, sets_it); }))
    names.insert(file_.scenario);
  return {names.begin(), names.end()};
}

double CampaignPlan::LevelValue(std::size_t level) const {
  // In the heap, depth d begins at index 2^d - 1, and its values are the centres of 2^d equal parts.
  const std::size_t begin = std::bit_floor(level + 1) - 1;
  const double parts = static_cast<double>(begin + 1);
  const double middle = (static_cast<double>(level - begin) + 0.5) / parts;
  return file_.limit->from + middle * (file_.limit->to - file_.limit->from);
}

std::vector<std::size_t> CampaignPlan::LabelsAt(std::size_t point) const {
  std::vector<std::size_t> at(axes_.size());
  for (std::size_t i = axes_.size(); i-- > 0;
       point /= axes_[i].labels.size())  // the last axis changes fastest
    at[i] = point % axes_[i].labels.size();
  return at;
}

std::vector<std::pair<std::string, std::string>> CampaignPlan::AtPoint(std::size_t point) const {
  const std::vector<std::size_t> labels = LabelsAt(point);
  std::vector<std::pair<std::string, std::string>> at;
  for (std::size_t i = 0; i < axes_.size(); ++i) at.emplace_back(axes_[i].name, axes_[i].labels[labels[i]]);
  return at;
}

RunSetup CampaignPlan::Setup(std::size_t run) const {
  const std::size_t k = run % num_seeds();
  RunSetup setup{.seed = file_.seeds.first + k, .scenario = file_.scenario, .settings = {}, .varied = {}};
  for (const auto& [key, value] : file_.set) setup.settings.emplace_back(key, value.text);

  const std::vector<std::size_t> labels = LabelsAt(PointOf(run));
  std::size_t next_axis = 0, next_drawn = 0;
  for (const std::string& name : order_) {
    if (file_.vary.at(name).multiplies()) {
      const Axis& axis = axes_[next_axis];
      const std::size_t label = labels[next_axis++];
      setup.varied.emplace_back(axis.name, axis.labels[label]);
      for (const Setting& setting : axis.settings[label]) {
        if (setting.key == "scenario") {
          setup.scenario = Unquoted(setting.value);
        } else {
          setup.settings.emplace_back(setting.key, setting.value);
        }
      }
    } else {
      const Drawn& by = drawn_[next_drawn++];
      const double value = by.draw(setup.seed, k);
      setup.varied.emplace_back(name, Text(value));
      for (const auto& [key, factor] : by.sets) setup.settings.emplace_back(key, Text(factor * value));
    }
  }
  const auto set = [&](const std::string& name, const std::map<std::string, double>& sets, double value) {
    setup.varied.emplace_back(name, Text(value));
    for (const auto& [key, factor] : Targets(name, sets))
      setup.settings.emplace_back(key, Text(factor * value));
  };
  if (file_.limit) set(file_.limit->key, file_.limit->sets, LevelValue(LevelOf(run)));
  for (const auto& [name, value] : chosen_) set(name, file_.optimise->vary.at(name).sets, value);
  return setup;
}

CampaignSchedule::CampaignSchedule(const CampaignPlan& plan, Shard shard, std::size_t ahead)
    : plan_(plan), shard_(shard), ahead_(ahead) {
  if (!adaptive()) {
    done_.resize(plan.size());
    return;
  }
  sequences_.resize(plan.num_points());
  open_ = sequences_.size();
  if (plan.file().limit)
    for (Sequence& at : sequences_) at.limit = {plan.file().limit->from, plan.file().limit->to};
}

/// Runs all points with the first seed, then with the second, so that an interrupted campaign covers all
/// points.
std::optional<std::size_t> CampaignSchedule::NextFixed() {
  for (; cursor_ < plan_.size(); ++cursor_) {
    const std::size_t run = plan_.RunOf(cursor_ % plan_.num_points(), 0, cursor_ / plan_.num_points());
    if (done_[run] || !shard_.Has(run)) continue;
    ++cursor_;
    started_.insert(run);
    return run;
  }
  return {};
}

std::optional<std::size_t> CampaignSchedule::NextAdaptive() {
  for (std::size_t i = 0; i < sequences_.size(); ++i) {
    const std::size_t point = turn_++ % sequences_.size();
    Sequence& at = sequences_[point];
    if (at.over) continue;
    for (; at.next < plan_.num_seeds() && at.next < at.judged + ahead_; ++at.next) {
      const std::size_t run = plan_.RunOf(point, at.level, at.next);
      if (known_.contains(run) || !started_.insert(run).second) continue;
      ++at.next;
      return run;
    }
  }
  return {};
}

void CampaignSchedule::Done(std::size_t run, bool survived) {
  started_.erase(run);
  if (!adaptive()) {
    done_[run] = true;
    return;
  }
  known_[run] = survived;
  Judge(plan_.PointOf(run));
}

bool CampaignSchedule::Lost(std::size_t run) {
  started_.erase(run);
  return !adaptive();
}

void CampaignSchedule::Judge(std::size_t point) {
  Sequence& at = sequences_[point];
  while (!at.over) {
    const auto result = known_.find(plan_.RunOf(point, at.level, at.judged));
    if (result == known_.end()) return;
    ++at.judged;
    at.survived += result->second ? 1 : 0;
    if (at.judged < plan_.num_seeds() && !Decided(at)) continue;

    counted_[{point, at.level}] = at.judged;
    if (!plan_.file().limit || ++at.steps == plan_.file().limit->steps) at.over = true;
    if (plan_.file().limit) {
      const bool survives = static_cast<double>(at.survived) >=
                            plan_.file().limit->probability * static_cast<double>(at.judged);
      (survives ? at.limit.survives : at.limit.fails) = plan_.LevelValue(at.level);
      at.level = 2 * at.level + (survives ? 2 : 1);
      at.judged = at.survived = at.next = 0;
    }
    if (at.over) --open_;
  }
}

bool CampaignSchedule::Decided(const Sequence& at) const {
  const CampaignFile& file = plan_.file();
  if (!file.limit)
    return WilsonInterval(at.survived, at.judged, file.confidence).width() <= file.interval_width;
  // Tests after 8, 16, 32, … seeds share the risk of a wrong decision.
  constexpr std::size_t kFirstLook = 8;
  if (at.judged % kFirstLook != 0 || !std::has_single_bit(at.judged / kFirstLook)) return false;
  const auto looks = static_cast<double>(std::bit_width(plan_.num_seeds() / kFirstLook));
  const double confidence = 1 - (1 - file.confidence) / looks;
  const Interval interval = WilsonInterval(at.survived, at.judged, confidence);
  return interval.low > file.limit->probability || interval.high < file.limit->probability;
}

bool CampaignSchedule::Counts(std::size_t run) const {
  if (!adaptive()) return run < plan_.size();
  const auto found = counted_.find({plan_.PointOf(run), plan_.LevelOf(run)});
  return found != counted_.end() && run % plan_.num_seeds() < found->second;
}

std::optional<std::size_t> CampaignSchedule::total() const {
  if (adaptive()) return {};
  const std::size_t rest = plan_.size() % shard_.count;
  return plan_.size() / shard_.count + (shard_.index <= rest ? 1 : 0);
}

}  // namespace tenon::apps
