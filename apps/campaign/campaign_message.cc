#include <tenon/apps/campaign/campaign_message.h>

#include <nlohmann/json.hpp>

namespace tenon::apps {

std::string Pack(const CampaignMessage& message) {
  nlohmann::json json{{"run", message.run}};
  if (message.result) {
    json["row"] = message.result->row;
    json["survived"] = message.result->survived;
    json["machine_failure"] = message.result->machine_failure;
  }
  return json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

CampaignMessage Unpack(const std::string& text) {
  const auto json = nlohmann::json::parse(text);
  CampaignMessage message;
  message.run = json["run"].get<std::size_t>();
  if (json.contains("row"))
    message.result = CampaignResult{.row = json["row"].get<CampaignRow>(),
                                    .survived = json["survived"].get<bool>(),
                                    .machine_failure = json["machine_failure"].get<std::string>()};
  return message;
}

}  // namespace tenon::apps
