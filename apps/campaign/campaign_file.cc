#include <tenon/apps/campaign/campaign_file.h>

#include <fmt/core.h>

namespace tenon::apps {
namespace {

void DemandFactors(const std::map<std::string, double>& sets) {
  for (const auto& [key, factor] : sets)
    if (factor == 0)
      throw ParameterError(fmt::format("sets: the factor of {} is 0, so that it would not vary", key));
}

}  // namespace

void Variation::Validate() const {
  const int ways = !grid.empty() + linspace.has_value() + !list.empty() + !choices.empty() +
                   uniform.has_value() + normal.has_value() + lognormal.has_value() + sobol.has_value();
  if (ways != 1)
    throw ParameterError(fmt::format(
        "{} ways to vary are given: give exactly one of grid, linspace, list, choices, uniform, normal, "
        "lognormal, sobol",
        ways));
  if (!sets.empty() && (!list.empty() || !choices.empty()))
    throw ParameterError("sets: factors apply to numbers only; remove them from a list or choices");
  DemandFactors(sets);
  if (linspace) {
    const double count = (*linspace)[2];
    if (count != std::floor(count) || count < 2 || count > 1e6)
      throw ParameterError(fmt::format(
          "linspace: [from, to, count] has a count of {:.6g}: give an integer from 2 to 1000000", count));
  }
  if (sobol && (*sobol)[0] > (*sobol)[1])
    throw ParameterError(fmt::format("[{}, {}]: give the lower bound first", (*sobol)[0], (*sobol)[1]));
  if (const auto drawn = distribution()) drawn->Validate();
}

std::optional<Distribution> Variation::distribution() const {
  if (uniform) return Distribution::Named("uniform", *uniform);
  if (normal) return Distribution::Named("normal", *normal);
  if (lognormal) return Distribution::Named("lognormal", *lognormal);
  return {};
}

void SeedRange::Validate() const {
  if (first > std::numeric_limits<std::uint64_t>::max() - count)
    throw ParameterError(fmt::format("first = {}: the last seed would exceed 64 bits", first));
}

void LimitSearch::Validate() const {
  DemandFactors(sets);
  if (!(from < to)) throw ParameterError(fmt::format("from = {} must be below to = {}", from, to));
}

void SearchedKey::Validate() const {
  DemandFactors(sets);
  if (!(from < to)) throw ParameterError(fmt::format("from = {} must be below to = {}", from, to));
  if (logarithmic && from <= 0)
    throw ParameterError(fmt::format("from = {} must be positive with logarithmic: true", from));
  if (start && (*start < from || *start > to))
    throw ParameterError(fmt::format("start = {} must be between {} and {}", *start, from, to));
}

void Optimisation::Validate() const {
  if (vary.empty()) throw ParameterError("vary names no key: give at least one with from and to");
  if (minimise.empty()) throw ParameterError("minimise names no figure: give at least one with its weight");
}

void QuantileGoal::Validate() const {
  if (at_most.has_value() == at_least.has_value())
    throw ParameterError(fmt::format("the goal of {} needs either at_most or at_least", figure));
}

void CampaignFile::Validate() const {
  if (limit && estimate != Estimate::kAll)
    throw ParameterError("estimate and limit exclude each other; remove estimate");
  if (optimise && (limit || estimate != Estimate::kAll))
    throw ParameterError("optimise counts all seeds of a campaign; remove limit and estimate");
  if (!goals.empty() && (limit || optimise))
    throw ParameterError("goals are those of a campaign without limit and optimise; remove goals");
}

}  // namespace tenon::apps
