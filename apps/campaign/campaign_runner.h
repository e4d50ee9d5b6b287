#pragma once

#include <tenon/apps/campaign/campaign_plan.h>
#include <tenon/apps/campaign/campaign_table.h>
#include <tenon/apps/common/scenario_app.h>

namespace tenon::apps {

/// The result of a run.
struct CampaignResult {
  CampaignRow row;
  bool survived = false;  ///< the run reached its end
  int exit_code = 0;      ///< ExitCode of the app
  /// Why the machine could not complete the run: a full disk, lack of memory, a missing program. Empty if it
  /// could. Such a run says nothing about the robot and has no row.
  std::string machine_failure{};
};

/// Executes runs of a plan and returns their rows. It is immutable and thread-safe.
class CampaignRunner {
 public:
  /// Reads all scenarios and checks the first run of at most a hundred points. If none of these can run,
  /// throws ParameterError with the place of the invalid key in the campaign's file.
  CampaignRunner(const CampaignPlan& plan, const YamlDocument& file, ScenarioApp app);

  /// Executes a run. An exception becomes a row with its message, or a failure of the machine. Empty if a
  /// signal stopped the run.
  std::optional<CampaignResult> Run(std::size_t run) const;
  /// Executes a run with all outputs in a directory and does not catch exceptions.
  CampaignResult Replay(std::size_t run, const std::filesystem::path& out) const;
  /// Returns the columns that are known before the run.
  CampaignRow Begin(std::size_t run) const;
  const ScenarioApp& app() const { return app_; }
  /// Numbers of checked and of refused points, and the reason of the first refusal.
  std::size_t num_checked() const { return num_checked_; }
  std::size_t num_refused() const { return num_refused_; }
  const std::string& refusal() const { return refusal_; }
  /// The error if the scenario of the first valid point does not accept the campaign's `duration_s`, for
  /// example because its figures begin later; else empty.
  const std::string& cut_short() const { return cut_short_; }
  /// Returns all scenarios as text, for comparison.
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

/// Makes an app of a separate program whose main function calls RunApp. Each run is a process, and its
/// figures are read from its summary.json. The program itself refuses scenarios of other apps. Throws
/// ParameterError if it is not executable.
ScenarioApp ProgramApp(const std::filesystem::path& program);

}  // namespace tenon::apps
