#include <tenon/apps/common/blame.h>
#include <tenon/apps/common/checks.h>
#include <tenon/apps/common/faults.h>
#include <tenon/systems/framework/types/errors.h>

#include <fmt/format.h>

#include <algorithm>
#include <exception>

namespace tenon::apps {
namespace {

/// Returns the innermost message, without the context that blocks add.
std::string FirstMessage(const std::exception& error) {
  try {
    std::rethrow_if_nested(error);
  } catch (const std::exception& inner) {
    return FirstMessage(inner);
  }
  return error.what();
}

}  // namespace

FieldList Fault::Fields() {
  return {Required("kind", &Fault::kind), {"elements", &Fault::elements},
          {"start_s", &Fault::start_s},   {"duration_s", &Fault::duration_s},
          {"size", &Fault::size},         {"period_s", &Fault::period_s},
          {"samples", &Fault::samples},   {"probability", &Fault::probability}};
}

void Fault::Validate() const {
  const auto belongs = [&](const char* key, bool given, bool needed, const char* to) {
    Demand(given || !needed, fmt::format("a fault of kind '{}' needs {}: add it", EnumName(kind), key));
    Demand(!given || needed,
           fmt::format("{} applies to {}, not to a fault of kind '{}': remove it", key, to, EnumName(kind)));
  };
  using enum FaultKind;
  belongs("size", size.has_value(), kind == kSpike || kind == kOffset || kind == kLoss,
          "spike, offset and loss");
  belongs("samples", samples.has_value(), kind == kLate, "late");
  belongs("probability", probability.has_value(), kind == kLost, "lost");
  if (period_s) belongs("period_s", true, kind == kSpike, "spike");
  DemandNotNegative("start_s", start_s);
  if (duration_s) DemandNotNegative("duration_s", *duration_s);
  if (period_s) DemandPositive("period_s", *period_s);
  if (samples) DemandBetween("samples", *samples, 1, 1e6);
  if (probability) DemandBetween("probability", *probability, 0, 1);
}

std::vector<int> Fault::Indices(const char* what, const std::vector<Element>& things) const {
  std::vector<int> indices;
  for (const std::string& element : elements) {
    const auto thing = std::ranges::find(things, element, &Element::name);
    if (thing == things.end()) {
      std::vector<std::string> names;
      for (const Element& other : things) names.push_back(other.name);
      throw ParameterError(fmt::format("elements: there is no {} '{}'; choose from {}", what, element,
                                       fmt::join(names, ", ")));
    }
    indices.push_back(static_cast<int>(thing - things.begin()));
  }
  return indices;
}

void FaultInserter::CheckCount(std::size_t count) {
  constexpr std::size_t kMost = 100;
  if (count > kMost)
    throw KeyError("faults",
                   fmt::format("there are {} faults, but at most {} are allowed: let elements of one "
                               "place share a fault",
                               count, kMost));
}

void FaultInserter::WithKey(std::size_t index, const char* place, const std::function<void()>& insert) {
  try {
    insert();
  } catch (const ParameterError& error) {
    throw KeyError(fmt::format("faults.{}", index), fmt::format("at '{}': {}", place, FirstMessage(error)));
  }
}

void DemandKind(const Fault& fault, const std::vector<FaultKind>& possible) {
  std::vector<const char*> names;
  for (const FaultKind kind : possible) {
    if (kind == fault.kind) return;
    names.push_back(EnumName(kind));
  }
  throw ParameterError(fmt::format("kind '{}' is not possible at this place: choose {}", EnumName(fault.kind),
                                   fmt::join(names, " or ")));
}

void DemandPeriod(const Fault& fault, const Rate& rate) {
  if (!fault.period_s || *fault.period_s >= rate.period()) return;
  throw ParameterError(fmt::format("period_s = {} is below the sample period of {} s; increase it",
                                   *fault.period_s, rate.period()));
}

SignalFaultKind SignalKind(const Fault& fault) {
  for (const auto& [kind, name] : EnumNames(SignalFaultKind{})) {
    if (std::string_view(name) == EnumName(fault.kind)) return kind;
  }
  throw ParameterError(fmt::format(
      "kind '{}' is not possible at this place: it applies to mechanical parts, not signals; choose "
      "another",
      EnumName(fault.kind)));
}

void ThrowUnread(const char* remedy) {
  throw ParameterError(fmt::format("no block of this scenario's diagram reads that signal: {}", remedy));
}

}  // namespace tenon::apps
