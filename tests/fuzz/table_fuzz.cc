// Text as the table of a campaign.

#include <tenon/apps/campaign/campaign_runner.h>
#include <tenon/tests/fuzz/refusals.h>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return tenon::fuzz::TryFile("runs.csv", data, size, [](const std::string& file) {
    using tenon::apps::CampaignTable;
    CampaignTable::Read(file, 10, [](std::size_t, const tenon::apps::CampaignRow&) {});
    CampaignTable(file, CampaignTable::Start::kResume).Finish([](std::size_t run) { return run < 10; });
  });
}
