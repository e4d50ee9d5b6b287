#include <tenon/apps/common/notes.h>

#include <fmt/core.h>

namespace tenon::apps {

void AddIdle(const std::string& key, const Acts& acts, double duration, const std::string& reason,
             std::vector<std::string>& notes) {
  std::string why = reason;
  if (why.empty() && acts.length == 0) why = "duration_s is 0";
  if (why.empty() && acts.start >= duration)
    why = fmt::format("start_s = {:.10g}, and the run ends at {:.10g} s", acts.start, duration);
  if (why.empty() && acts.length > 0 && acts.start + acts.length <= 0)
    why = fmt::format("start_s = {:.10g}, and it ends before the run begins", acts.start);
  if (!why.empty()) notes.push_back(fmt::format("{} never acts: {}", key, why));
}

}  // namespace tenon::apps
