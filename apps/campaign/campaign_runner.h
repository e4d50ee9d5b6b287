#pragma once

#include <tenon/apps/campaign/campaign_plan.h>
#include <tenon/apps/campaign/campaign_table.h>
#include <tenon/apps/common/scenario_app.h>

#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace tenon::apps {

/// What a run came to.
struct CampaignResult {
  CampaignRow row;
  bool survived = false;  ///< it reached its end
  int exit_code = 0;      ///< an ExitCode, as the app's own
};

/// Turns the runs of a plan into rows. Constant: any number of threads may run.
class CampaignRunner {
 public:
  /// Reads all scenarios; of the points of the plan, or a hundred of them, the first run is checked. Throws
  /// ParameterError, with the place in the campaign's file of the key that is refused, if none can run.
  CampaignRunner(const CampaignPlan& plan, const YamlDocument& file, ScenarioApp app);

  /// Runs one. What is thrown is a row with its reason. Nothing if a signal stopped it.
  std::optional<CampaignResult> Run(std::size_t run) const;
  /// The same with all outputs in a directory; throws what it throws.
  CampaignResult Replay(std::size_t run, const std::filesystem::path& out) const;
  /// The columns of a run that are known before it has run.
  CampaignRow Begin(std::size_t run) const;
  /// How many of the points that were checked are refused, with the reason of the first.
  std::size_t num_checked() const { return num_checked_; }
  std::size_t num_refused() const { return num_refused_; }
  const std::string& refusal() const { return refusal_; }
  /// Why the scenario of the first point that can run would not take `duration_s` for its own time, as of one
  /// that ends before its figures begin; empty if it would.
  const std::string& cut_short() const { return cut_short_; }
  /// All scenarios as they are read, for comparing.
  std::string ScenarioTexts() const;

 private:
  struct Prepared {
    YamlDocument scenario;
    CampaignRow row;
  };
  Prepared Prepare(std::size_t run) const;

  const CampaignPlan& plan_;
  ScenarioApp app_;
  std::map<std::string, YamlDocument> scenarios_;
  std::size_t num_checked_ = 0, num_refused_ = 0;
  std::string refusal_, cut_short_;
};

}  // namespace tenon::apps
