#pragma once

#include <tenon/apps/common/summary.h>

#include <map>
#include <string>
#include <utility>

namespace tenon::apps {

/// What a robot did and could not have, each kind once, when it first happened.
class Breaches {
 public:
  /// `what` says the kind first, up to a colon, then the place and by how much.
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
