#pragma once

#include <tenon/apps/campaign/campaign_runner.h>

#include <cstddef>
#include <optional>
#include <string>

namespace tenon::apps {

/// Message of an MPI rank to rank 0 about a completed run.
struct CampaignMessage {
  std::size_t run = 0;
  std::optional<CampaignResult> result;  ///< empty if a signal stopped the run
};

/// Serializes a message for Unpack. Bytes that are not UTF-8 become U+FFFD.
std::string Pack(const CampaignMessage& message);
/// Parses a text of Pack. Throws nlohmann::json::exception for other texts.
CampaignMessage Unpack(const std::string& text);

}  // namespace tenon::apps
