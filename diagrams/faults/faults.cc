#include <tenon/diagrams/faults/faults.h>

#include <fmt/format.h>

#include <exception>

namespace tenon {
namespace {

/// The innermost message, without the names of blocks that DiagramBuilder puts in front.
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
  return {Required("kind", &Fault::kind),
          {"elements", &Fault::elements},
          Field("start_s", &Fault::start_s).AtLeast(0),
          Field("duration_s", &Fault::duration_s).AtLeast(0),
          {"size", &Fault::size},
          Field("period_s", &Fault::period_s).Positive(),
          Field("samples", &Fault::samples).Between(1, 1e6),
          Field("probability", &Fault::probability).Between(0, 1)};
}

void Fault::Validate() const {
  const auto belongs = [&](const char* key, bool given, bool needed, const char* to) {
    Demand(given || !needed, fmt::format("a fault of kind '{}' needs {}: add it", EnumName(kind), key));
    Demand(!given || needed,
           fmt::format("{} is for {}, not for a fault of kind '{}': remove it", key, to, EnumName(kind)));
  };
  using enum FaultKind;
  belongs("size", size.has_value(), kind == kSpike || kind == kOffset || kind == kLoss,
          "spike, offset and loss");
  belongs("samples", samples.has_value(), kind == kLate, "late");
  belongs("probability", probability.has_value(), kind == kLost, "lost");
  if (period_s) belongs("period_s", true, kind == kSpike, "spike");
}

std::vector<int> Fault::Indices(const char* type, const std::vector<Element>& parts) const {
  std::vector<int> indices;
  for (const std::string& element : elements) {
    const auto part = std::ranges::find(parts, element, &Element::name);
    if (part == parts.end()) {
      std::vector<std::string> names;
      for (const Element& other : parts) names.push_back(other.name);
      throw ParameterError(fmt::format("elements: there is no {} '{}', give some of {}", type, element,
                                       fmt::join(names, ", ")));
    }
    indices.push_back(static_cast<int>(part - parts.begin()));
  }
  return indices;
}

void FaultInserter::CheckCount(std::size_t count) {
  constexpr std::size_t kMost = 100;
  Demand(count <= kMost, fmt::format("{} faults are too many, at most {} are possible: give one fault "
                                     "several elements of a place",
                                     count, kMost));
}

void FaultInserter::InsertOne(std::size_t index, const char* place,
                              const std::function<void(const std::string& name)>& insert) {
  const std::string name = fmt::format("fault_{}", index);
  try {
    insert(name);
  } catch (const ParameterError& error) {
    throw FaultError(index, fmt::format("{} at '{}': {}", name, place, FirstMessage(error)));
  } catch (const BuildError& error) {
    throw FaultError(index, fmt::format("{} at '{}': {}", name, place, FirstMessage(error)));
  }
}

void DemandKind(const Fault& fault, const std::vector<FaultKind>& possible) {
  if (std::ranges::find(possible, fault.kind) != possible.end()) return;
  std::vector<const char*> names;
  for (const FaultKind kind : possible) names.push_back(EnumName(kind));
  throw ParameterError(fmt::format("kind '{}' is not possible there: give {}", EnumName(fault.kind),
                                   fmt::join(names, " or ")));
}

namespace internal {

void DemandPeriod(const Fault& fault, const Rate& rate) {
  if (!fault.period_s || *fault.period_s >= rate.period()) return;
  throw ParameterError(
      fmt::format("period_s = {} is shorter than the sample period of {} s", *fault.period_s, rate.period()));
}

SignalFaultKind SignalKind(const Fault& fault) {
  for (const auto& [kind, name] : EnumNames(SignalFaultKind{})) {
    if (std::string_view(name) == EnumName(fault.kind)) return kind;
  }
  throw ParameterError(fmt::format(
      "kind '{}' is not possible there: it is for mechanical parts, this is a signal; give another kind",
      EnumName(fault.kind)));
}

Rate RateOf(const Source& signal) {
  const Source& origin = signal.Current().Resolve();
  return origin.is_sampled() ? origin.trigger().sampled.rate : Hz(1000);
}

void ThrowUnread(const Source* signal, const char* hint) {
  throw ParameterError(signal == nullptr ? fmt::format("no block reads this signal: {}", hint)
                                         : fmt::format("no block reads '{}' ({}): {}", signal->path(),
                                                       signal->type_name(), hint));
}

}  // namespace internal
}  // namespace tenon
