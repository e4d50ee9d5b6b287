#include <tenon/systems/campaign/campaign.h>
#include <tenon/systems/campaign/sampling.h>
#include <tenon/systems/campaign/statistics.h>

#include <boost/math/distributions/binomial.hpp>
#include <boost/math/distributions/normal.hpp>
#include <boost/random/sobol.hpp>
#include <fmt/core.h>

#include <atomic>
#include <mutex>
#include <numeric>
#include <thread>

namespace tenon {

void ForEachRun(std::size_t count, int jobs, const std::function<void(std::size_t)>& work) {
  if (jobs < 1)
    throw ParameterError(fmt::format("jobs = {} must be positive: set the number of parallel runs", jobs));
  std::atomic<std::size_t> next = 0;
  std::atomic<bool> failed = false;
  std::mutex mutex;
  std::exception_ptr failure;
  const auto take = [&] {
    for (std::size_t k; !failed && (k = next++) < count;) {
      try {
        work(k);
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (!failure) failure = std::current_exception();
        failed = true;
      }
    }
  };
  {
    std::vector<std::jthread> others;
    const std::size_t wanted = std::min(static_cast<std::size_t>(jobs), count);
    for (std::size_t i = 1; i < wanted; ++i) others.emplace_back(take);
    take();
  }
  if (failure) std::rethrow_exception(failure);
}

std::vector<std::vector<double>> Sobol(std::size_t count, std::size_t dimensions) {
  if (dimensions == 0) return {};
  std::vector<std::vector<double>> points(dimensions, std::vector<double>(count));
  if (count == 0) return points;
  using Engine = boost::random::sobol_engine<std::uint_least64_t, 64u>;
  try {
    Engine engine(dimensions);
    for (std::size_t k = 0; k < count; ++k)
      for (auto& coordinate : points)
        coordinate[k] = static_cast<double>(engine() >> 11) * std::ldexp(1.0, -53);
  } catch (const std::invalid_argument&) {
    throw ParameterError(
        fmt::format("Sobol's sequence in {} dimensions exceeds the available direction numbers; draw some "
                    "keys by uniform",
                    dimensions));
  }
  return points;
}

Interval WilsonInterval(std::size_t successes, std::size_t trials, double confidence) {
  if (successes > trials)
    throw ParameterError(
        fmt::format("{} successes of {} trials: successes must not exceed trials", successes, trials));
  if (!(confidence > 0 && confidence < 1))
    throw ParameterError(fmt::format("confidence = {} must lie between 0 and 1, as in 0.95", confidence));
  if (trials == 0) return {0, 1};
  const double z = boost::math::quantile(boost::math::normal(), (1 + confidence) / 2);
  const auto n = static_cast<double>(trials);
  const double p = static_cast<double>(successes) / n;
  const double centre = (p + z * z / (2 * n)) / (1 + z * z / n);
  const double half = z / (1 + z * z / n) * std::sqrt(p * (1 - p) / n + z * z / (4 * n * n));
  return {successes == 0 ? 0 : centre - half, successes == trials ? 1 : centre + half};
}

QuantileEstimate EstimateQuantile(std::vector<double> values, double share, double confidence) {
  for (const auto& [name, given] : {std::pair("share", share), std::pair("confidence", confidence)})
    if (!(given > 0 && given < 1))
      throw ParameterError(fmt::format("{} = {} must lie between 0 and 1, as in 0.95", name, given));
  const auto n = values.size();
  if (n == 0) throw ParameterError("a quantile of no values: give at least one");
  if (std::ranges::any_of(values, [](double value) { return std::isnan(value); }))
    throw ParameterError("a quantile of values with a NaN: leave it out, or count it as infinite");
  std::ranges::sort(values);
  // k of the values lie below the quantile, where k has a binomial distribution.
  const boost::math::binomial below(static_cast<double>(n), share);
  const double tail = (1 - confidence) / 2;
  const auto middle = static_cast<std::size_t>(std::ceil(static_cast<double>(n) * share - 1e-9));
  std::size_t low = middle, high = middle;  // positions from 1
  while (low > 0 && boost::math::cdf(below, static_cast<double>(low - 1)) > tail) --low;
  while (high <= n && boost::math::cdf(boost::math::complement(below, static_cast<double>(high - 1))) > tail)
    ++high;
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  return {values[middle - 1],
          {low == 0 ? -kInfinity : values[low - 1], high > n ? kInfinity : values[high - 1]}};
}

namespace {

/// Returns ranks from 0; equal values have the mean of their ranks.
std::vector<double> Ranks(std::span<const double> values) {
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, {}, [&](std::size_t i) { return values[i]; });
  std::vector<double> ranks(values.size());
  for (std::size_t begin = 0, end = 0; begin < order.size(); begin = end) {
    while (end < order.size() && values[order[end]] == values[order[begin]]) ++end;
    for (std::size_t i = begin; i < end; ++i) ranks[order[i]] = 0.5 * static_cast<double>(begin + end - 1);
  }
  return ranks;
}

}  // namespace

std::optional<double> RankCorrelation(std::span<const double> x, std::span<const double> y) {
  if (x.size() != y.size() || x.size() < 3) return {};
  const auto is_nan = [](double value) { return std::isnan(value); };
  if (std::ranges::any_of(x, is_nan) || std::ranges::any_of(y, is_nan)) return {};
  const std::vector<double> a = Ranks(x), b = Ranks(y);
  const double mean = 0.5 * static_cast<double>(x.size() - 1);
  double aa = 0, bb = 0, ab = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    aa += (a[i] - mean) * (a[i] - mean);
    bb += (b[i] - mean) * (b[i] - mean);
    ab += (a[i] - mean) * (b[i] - mean);
  }
  if (aa == 0 || bb == 0) return {};
  return ab / std::sqrt(aa * bb);
}

}  // namespace tenon
