#pragma once

#include <tenon/apps/common/summary.h>

#include <map>
#include <string>
#include <utility>

namespace tenon::apps {

/// Physically impossible events of a run; only the first event of each kind is kept.
class Breaches {
 public:
  /// Adds an event at `time` [s]. `what` describes where it happened and by how much.
  void Add(double time, const std::string& kind, const std::string& what) {
    first_.try_emplace(kind, time, kind + ": " + what);
  }
  void AddTo(Summary& summary) const {
    for (const auto& [kind, breach] : first_) summary.Break(breach.first, breach.second);
  }

 private:
  std::map<std::string, std::pair<double, std::string>> first_;
};

}  // namespace tenon::apps
