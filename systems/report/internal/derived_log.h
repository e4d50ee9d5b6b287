#pragma once

#include <tenon/systems/report/report.h>
#include <tenon/systems/simulation/signal_log.h>

#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace tenon::internal {

/// Whether a name in a plot stands for a path, `xy:NAME`.
bool IsPath(std::string_view name);

/// Returns a sink that appends to each row the columns `norm:NAME` and `rate:NAME` that the plots name, see
/// Plot, and passes it to `sink`; or `sink` itself, if they name none.
std::shared_ptr<LogSink> WithDerived(const std::vector<Plot>& plots, std::shared_ptr<LogSink> sink);

}  // namespace tenon::internal
