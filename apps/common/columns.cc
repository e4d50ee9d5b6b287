#include <tenon/apps/common/columns.h>
#include <tenon/systems/framework/types/errors.h>

#include <fmt/core.h>

#include <algorithm>

namespace tenon::apps {

std::size_t Column(const std::vector<std::string>& names, const std::string& signal) {
  const auto at = std::find(names.begin(), names.end(), signal);
  if (at == names.end()) throw Error(fmt::format("the log has no signal '{}'", signal));
  return static_cast<std::size_t>(at - names.begin());
}

std::vector<std::size_t> Columns(const std::vector<std::string>& names, const std::string& signal) {
  std::vector<std::size_t> columns;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i].starts_with(signal + ".")) columns.push_back(i);
  }
  if (columns.empty()) throw Error(fmt::format("the log has no signal '{}'", signal));
  return columns;
}

}  // namespace tenon::apps
