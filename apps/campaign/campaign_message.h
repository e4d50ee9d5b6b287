#pragma once

#include <tenon/apps/campaign/campaign_runner.h>

#include <cstddef>
#include <optional>
#include <string>

namespace tenon::apps {

/// What a rank tells the writer of a run that ended.
struct CampaignMessage {
  std::size_t run = 0;
  std::optional<CampaignResult> result;  ///< none if a signal stopped it
};

/// As text that Unpack reads; what is no UTF-8 in a cell becomes U+FFFD.
std::string Pack(const CampaignMessage& message);
/// Throws nlohmann::json::exception where `text` is not from Pack.
CampaignMessage Unpack(const std::string& text);

}  // namespace tenon::apps
