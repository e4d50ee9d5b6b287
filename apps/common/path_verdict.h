#pragma once

#include <tenon/apps/common/summary.h>
#include <tenon/apps/common/tally.h>

#include <optional>
#include <utility>

namespace tenon::apps {

/// Whether a robot followed its path. The largest deviation of its position may be `tolerance` times the
/// length of the path, that of its heading `tolerance` times half a turn. Where the path has no length, the
/// position is not judged; without a path nothing is.
class PathVerdict {
 public:
  /// Without a path.
  PathVerdict() = default;
  /// A robot that starts aside of its path, by `offset` and `turned`, may deviate by as much more.
  PathVerdict(double tolerance, double length /* [m] */, double offset = 0 /* [m] */,
              double turned = 0 /* [rad] */);

  void Add(double time, double deviation /* [m] */, double turn /* [rad] */);
  /// The key `followed`, null without a path, and the deviations with their limits. A path that was not
  /// followed makes a run one that is not finished.
  void AddTo(Summary& summary) const;

 private:
  bool judged_ = false;
  std::optional<double> position_limit_, heading_limit_;  // [m], [rad]
  Tally deviations_, turns_;                              // [m], [rad]
  std::optional<double> left_, turned_;                   // when first beyond the limits [s]
};

}  // namespace tenon::apps
