#include <tenon/systems/analysis/internal/period_map.h>
#include <tenon/systems/framework/diagram/internal/program.h>
#include <tenon/systems/simulation/simulator.h>

#include <fmt/core.h>

#include <numeric>

namespace tenon::internal {
namespace {

/// Relative tolerance of times, in periods.
constexpr double kRounding = 1e-9;

/// Returns the least common multiple of all sample periods, 0 without samples.
Rational CommonPeriod(const std::vector<SampleGroup>& groups) {
  // For reduced fractions, it is the least common multiple of the numerators over the greatest common divisor
  // of the denominators.
  Rational common{0, 1};
  for (const SampleGroup& group : groups) {
    const std::int64_t divisor = std::gcd(group.period.numerator, group.period.denominator);
    const Rational period{group.period.numerator / divisor, group.period.denominator / divisor};
    if (common.numerator == 0) {
      common = period;
      continue;
    }
    const std::int64_t factor = period.numerator / std::gcd(common.numerator, period.numerator);
    if (__builtin_mul_overflow(common.numerator, factor, &common.numerator)) {
      throw ParameterError(
          fmt::format("the sample times of '{}' and '{}' have no common period: round their periods",
                      groups.front().example, group.example));
    }
    common.denominator = std::gcd(common.denominator, period.denominator);
  }
  return common;
}

double ToDouble(const Rational& rational) {
  return static_cast<double>(rational.numerator) / static_cast<double>(rational.denominator);
}

void CheckSteps(const LinearizeDiscreteOptions& options) {
  if (options.steps.empty()) throw ParameterError("steps are empty: give at least one, such as 1e-5");
  for (const double step : options.steps) {
    if (!(step > 0)) throw ParameterError(fmt::format("step {} must be positive", step));
  }
  for (const auto& [unit, scale] : options.scales) {
    if (!(scale > 0)) throw ParameterError(fmt::format("scale {} of '{}' must be positive", scale, unit));
  }
}

}  // namespace

PeriodMap::PeriodMap(const Context& context, std::vector<const Source*> inputs,
                     std::vector<const Source*> outputs, const LinearizeDiscreteOptions& options)
    : options_(Silent(options)), outputs_(std::move(outputs)) {
  CheckSteps(options_);
  for (const Source* input : inputs) {
    if (!input->Resolve().is_sampled()) continue;
    throw RunError(
        fmt::format("input '{}' is sampled, so that a value would last only until its next tick; use an open "
                    "input",
                    input->path()));
  }
  FindBegin(context);
  ChooseStates();
  inputs_ = std::make_unique<RealNumbers>(*start_, std::move(inputs));
  ChooseScales();
}

double PeriodOf(const Diagram& diagram, const LinearizeDiscreteOptions& options) {
  const double common = ToDouble(CommonPeriod(diagram.program().groups));
  const double period = options.period == 0 ? common : options.period;
  if (period == 0) {
    throw ParameterError("this diagram has no samples and no period: give options.period");
  }
  if (!(period > 0) || !std::isfinite(period)) {
    throw ParameterError(fmt::format("period = {} s must be positive", period));
  }
  if (common > 0 && std::abs(std::remainder(period, common)) > kRounding * period) {
    throw ParameterError(fmt::format(
        "period = {} s must be a multiple of {} s, the common period of all sample times", period, common));
  }
  return period;
}

LinearizeDiscreteOptions Silent(LinearizeDiscreteOptions options) {
  options.simulator.publish = false;
  return options;
}

void RunToBefore(Simulator& simulator, double time) {
  const RunStatus status = simulator.AdvanceToBefore(time);
  if (status.ended) throw RunError(fmt::format("the run ended at t = {} s: {}", status.time, status.reason));
}

void PeriodMap::FindBegin(const Context& context) {
  const std::vector<SampleGroup>& groups = context.diagram().program().groups;
  period = PeriodOf(context.diagram(), options_);
  Simulator simulator(context.Clone(), options_.simulator);
  time = context.time();
  if (!groups.empty()) {
    double begin = time;
    for (const SampleGroup& group : groups) begin = std::max(begin, ToDouble(group.offset));
    const double common = ToDouble(CommonPeriod(groups));
    time = std::max(0.0, std::ceil(begin / common - kRounding)) * common;
    const bool is_here = std::abs(time - context.time()) < kRounding * common;
    if (is_here && simulator.next_tick_time() > context.time()) time += common;
  }
  RunToBefore(simulator, time);
  start_ = simulator.context().Clone();
  for (std::size_t i = 0; i < groups.size(); ++i) ticks_ |= NextTick(static_cast<int>(i)) == 0;
}

/// Begins at `time` [s].
double PeriodMap::NextTick(int group) const {
  const SampleGroup& samples = start_->diagram().program().groups[static_cast<std::size_t>(group)];
  const double each = ToDouble(samples.period);
  const double ago = std::fmod(time - ToDouble(samples.offset), each) / each;
  return ago < kRounding || ago > 1 - kRounding ? 0 : (1 - ago) * each;
}

/// Returns whether a held sample is read after `time` and before it is computed again.
bool PeriodMap::CarriesOn(int sample) const {
  const Program& program = start_->diagram().program();
  const double renewal = NextTick(program.calculations[static_cast<std::size_t>(sample)].group);
  std::vector<bool> seen(program.calculations.size(), false);
  std::vector<int> open{sample};
  while (!open.empty()) {
    const int i = open.back();
    open.pop_back();
    for (const int next : program.calculations[static_cast<std::size_t>(i)].affects) {
      const CalculationInfo& reader = program.calculations[static_cast<std::size_t>(next)];
      const SourceKind kind = reader.source->kind();
      if (kind == SourceKind::kMonitor) continue;  // monitors have no effect on the state
      if (reader.group >= 0) {
        if (NextTick(reader.group) < renewal - kRounding * period) return true;
      } else if (kind != SourceKind::kOutput && kind != SourceKind::kShared) {
        if (renewal > 0) return true;  // derivatives, witnesses, actions after each step
      } else if (!seen[static_cast<std::size_t>(next)]) {
        seen[static_cast<std::size_t>(next)] = true;
        open.push_back(next);
      }
    }
  }
  return false;
}

void PeriodMap::ChooseStates() {
  const Program& program = start_->diagram().program();
  carriers_ = program.continuous;
  for (const Cell& cell : program.cells) {
    const SourceKind kind = cell.source->kind();
    if (kind == SourceKind::kDiscrete || kind == SourceKind::kScratch) carriers_.push_back(cell.source);
  }
  for (std::size_t i = 0; i < program.calculations.size(); ++i) {
    if (program.calculations[i].sampled && CarriesOn(static_cast<int>(i)))
      carriers_.push_back(program.calculations[i].source);
  }
  std::vector<const Source*> states = options_.states.empty() ? carriers_ : options_.states;
  std::erase_if(states,
                [&](const Source* state) { return std::ranges::count(options_.left_out, state) > 0; });
  for (const Source*& state : states) {
    const Source* named = state;
    state = &state->Resolve();
    if (std::ranges::count(carriers_, state) > 0) continue;
    throw RunError(
        fmt::format("'{}' is not a state at t = {} s: states are continuous and discrete states, Scratch, "
                    "and held samples that "
                    "are read before they are computed again",
                    named->path(), time));
  }
  states_ = std::make_unique<RealNumbers>(*start_, std::move(states));
}

void PeriodMap::ChooseScales() {
  origin.resize(states_->size() + inputs_->size());
  origin << states_->Get(*start_), inputs_->Get(*start_);
  std::vector<std::string> units = states_->units();
  units.insert(units.end(), inputs_->units().begin(), inputs_->units().end());
  scales.resize(origin.size());
  for (Eigen::Index i = 0; i < origin.size(); ++i) {
    const auto found = options_.scales.find(units[static_cast<std::size_t>(i)]);
    scales[i] = found != options_.scales.end() ? found->second : 1 + std::abs(origin[i]);
  }
}

Eigen::VectorXd PeriodMap::Rates() const {
  const Eigen::VectorXd derivatives = start_->EvalTimeDerivatives();
  const std::vector<std::string> names = start_->diagram().ContinuousStateNames();
  Eigen::VectorXd rates = Eigen::VectorXd::Zero(states_->size());
  for (Eigen::Index i = 0; i < rates.size(); ++i) {
    const auto found = std::find(names.begin(), names.end(), states_->names()[static_cast<std::size_t>(i)]);
    if (found != names.end()) rates[i] = derivatives[found - names.begin()];
  }
  return rates;
}

PeriodMap::End PeriodMap::Run(const Eigen::VectorXd& from) const {
  std::unique_ptr<Context> start = start_->Clone();
  states_->Set(*start, from.head(states_->size()));
  inputs_->Set(*start, from.tail(inputs_->size()));
  End end;
  if (!ticks_) end.y = EvalNumbers(*start, outputs_);
  Simulator simulator(std::move(start), options_.simulator);
  std::shared_ptr<MemoryLog> log;
  if (ticks_ && !outputs_.empty()) {
    const Rational common = CommonPeriod(start_->diagram().program().groups);
    log = simulator.AddLog(Rate::FromPeriod(common.numerator, common.denominator), outputs_);
  }
  RunToBefore(simulator, time + period);
  if (log != nullptr) {
    const std::span<const double> row = log->row(0).subspan(1);
    end.y = Eigen::Map<const Eigen::VectorXd>(row.data(), static_cast<Eigen::Index>(row.size()));
  }
  end.x1 = states_->Get(simulator.context());
  end.context = simulator.context().Clone();
  return end;
}

std::vector<std::string> PeriodMap::Flips(const End& one, const End& other) const {
  std::vector<std::string> flips;
  for (const Source* source : carriers_) {
    const std::vector<Element> elements = one.context->Elements(*source);
    const std::vector<double> a = one.context->EvalDoubles(*source), b = other.context->EvalDoubles(*source);
    if (a.size() != b.size()) {
      flips.push_back(source->path());
      continue;
    }
    for (std::size_t i = 0; i < a.size(); ++i) {
      if (elements[i].is_real || a[i] == b[i]) continue;
      flips.push_back(elements[i].PathIn(source->path()));
    }
  }
  return flips;
}

}  // namespace tenon::internal
