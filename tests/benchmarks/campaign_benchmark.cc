// What a campaign costs beside its simulations: DogBot walks for a second, A4, over and over.
//
//   campaign/writer    the desk alone: a run given out, its row of 33 columns taken in and written
//   campaign/jobs/J    40 runs in J threads; counters: runs_per_s, and simulating, the part of the threads'
//   time
//                      that goes into the advance of the simulations (the rest reads scenarios, builds
//                      diagrams, writes rows)

#include <benchmark/benchmark.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <string>
#include <utility>

#include <tenon/apps/campaign/campaign_desk.h>
#include <tenon/apps/campaign/campaign_plan.h>
#include <tenon/apps/campaign/campaign_runner.h>
#include <tenon/apps/campaign/campaign_schedule.h>
#include <tenon/apps/campaign/campaign_table.h>
#include <tenon/apps/quadruped/quadruped_run.h>
#include <tenon/tests/testing/temporary_path.h>

namespace tenon::apps {
namespace {

YamlDocument File(std::size_t seeds) {
  return YamlDocument::Parse(
      "app: tenon-quadruped\nscenario: A4\nduration_s: 1\nseeds: {first: 101, count: " +
          std::to_string(seeds) + "}\n",
      "benchmark");
}

/// Goes with its object.
struct TableFile {
  ~TableFile() { std::filesystem::remove(path); }
  std::filesystem::path path = test::TemporaryPath("tenon_campaign_benchmark.csv");
};

void Writer(benchmark::State& state) {
  const YamlDocument file = File(10'000'000);
  const CampaignPlan plan(file);
  const CampaignRunner runner(plan, file, QuadrupedApp());
  const CampaignResult result = *runner.Run(0);
  const TableFile out;
  CampaignTable table(out.path, CampaignTable::Start::kNew);
  CampaignSchedule schedule(plan, {}, 1);
  CampaignDesk desk(schedule, table, 0);
  for (auto _ : state) desk.Put(*desk.Take(), result);
  state.counters["columns"] = static_cast<double>(result.row.size());
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(Writer)->Name("campaign/writer");

void Jobs(benchmark::State& state) {
  constexpr std::size_t kRuns = 40;
  const YamlDocument file = File(kRuns);
  const CampaignPlan plan(file);
  const CampaignRunner runner(plan, file, QuadrupedApp());
  const int jobs = static_cast<int>(state.range(0));
  double simulating = 0, all = 0;
  for (auto _ : state) {
    const TableFile out;
    CampaignTable table(out.path, CampaignTable::Start::kNew);
    CampaignSchedule schedule(plan, {}, 1);
    CampaignDesk desk(schedule, table, 0);
    const auto begin = std::chrono::steady_clock::now();
    WorkInThreads(desk, runner, jobs);
    all += jobs * std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    CampaignTable::Read(out.path, kRuns, [&](std::size_t, const CampaignRow& row) {
      simulating += std::stod(std::string(Cell(row, "wall_s")));
    });
  }
  state.counters["simulating"] = simulating / all;
  state.counters["runs_per_s"] =
      benchmark::Counter(static_cast<double>(kRuns * state.iterations()), benchmark::Counter::kIsRate);
}
BENCHMARK(Jobs)->Name("campaign/jobs")->Arg(1)->Arg(2)->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace tenon::apps
