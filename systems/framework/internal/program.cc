#include <tenon/systems/framework/internal/program.h>

namespace tenon::internal {

OpList Program::Needed(const std::vector<const Source*>& sinks, Which which, std::uint64_t due) const {
  std::vector<int> open;
  for (const Source* sink : sinks) {
    const CalculationInfo& info = calculations[sink->calculation_];
    if (info.sampled) {
      open.push_back(sink->calculation_);
    } else {
      open.insert(open.end(), info.uses.begin(), info.uses.end());
    }
  }
  std::vector<bool> wanted(calculations.size(), false);
  while (!open.empty()) {
    const int i = open.back();
    open.pop_back();
    const CalculationInfo& info = calculations[i];
    if (wanted[i] || (info.sampled && (info.group & due) == 0)) continue;
    wanted[i] = true;
    open.insert(open.end(), info.uses.begin(), info.uses.end());
  }
  OpList ops;
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    const CalculationInfo& info = calculations[i];
    if (!wanted[i] || (which == Which::kVarying && !info.varies) || (which == Which::kHeld && info.varies))
      continue;
    ops.push_back(info.op);
    ops.back().always = info.sampled;
  }
  return ops;
}

OpList Program::Evaluation(const std::vector<const Source*>& sources) const {
  std::vector<const Source*> computed;
  for (const Source* source : sources) {
    if (source->calculation_ >= 0) computed.push_back(source);
  }
  OpList ops = Needed(computed, Which::kAll);
  for (const Source* source : computed) {
    const CalculationInfo& info = calculations[source->calculation_];
    if (!info.sampled) ops.push_back(info.op);
  }
  return ops;
}

}  // namespace tenon::internal
