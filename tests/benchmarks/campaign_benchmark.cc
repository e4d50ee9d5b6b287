// Overhead of a campaign, which runs scenario A4 (DogBot walks, 1 s) many times.
//
//   campaign/writer    the desk alone: hands out a run, receives its row of 33 columns and writes it
//   campaign/message   the work of rank 0 for each run of another rank: unpacking the message, and the desk
//   campaign/jobs/J    40 runs in J threads. Counters: runs_per_s; simulating, the part of the threads' time
//                      in which simulations advance (the rest reads scenarios, builds diagrams, writes rows)
//   campaign/ranks/N   N ranks are simulated, event by event, with runs of 1 s on average. Rank 0 is the real
//                      one, and its time for each message is measured. Counters, in simulated time:
//                      runs_per_s; working, the part of the time in which a rank has a run; busy, the part
//                      of the time in which rank 0 works

#include <tenon/apps/campaign/campaign_desk.h>
#include <tenon/apps/quadruped/quadruped_app.h>
#include <tenon/tests/testing/temporary_path.h>

#include <benchmark/benchmark.h>

#include <cstdio>
#include <queue>

namespace tenon::apps {
namespace {

YamlDocument File(std::size_t seeds) {
  return YamlDocument::Parse(
      "app: tenon-quadruped\nscenario: A4\nduration_s: 1\nseeds: {first: 101, count: " +
          std::to_string(seeds) + "}\n",
      "benchmark");
}

/// A temporary file that is removed with its object.
struct TableFile {
  ~TableFile() { std::filesystem::remove(path); }
  std::filesystem::path path = test::TemporaryPath("tenon_campaign_benchmark.csv");
};

/// A desk with an endless supply of runs, and the result of one run.
class EndlessDesk {
 public:
  CampaignDesk& desk() { return desk_; }
  const CampaignResult& result() const { return result_; }
  /// Handles a message as rank 0 does: writes the row and hands out the next run.
  void Serve(const std::string& text) {
    const CampaignMessage message = Unpack(text);
    desk_.Put(message.run, message.result);
    benchmark::DoNotOptimize(desk_.TryTake());
  }

 private:
  const YamlDocument file_ = File(10'000'000);
  const CampaignPlan plan_{file_};
  const CampaignRunner runner_{plan_, file_, QuadrupedApp().AsScenarioApp()};
  const CampaignResult result_ = *runner_.Run(0);
  const TableFile out_;
  CampaignTable table_{out_.path, CampaignTable::Start::kNew};
  CampaignSchedule schedule_{plan_, {}, 1};
  CampaignDesk desk_{schedule_, table_, 0};
};

void Writer(benchmark::State& state) {
  EndlessDesk endless;
  for (auto _ : state) endless.desk().Put(*endless.desk().Take(), endless.result());
  state.counters["columns"] = static_cast<double>(endless.result().row.size());
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(Writer)->Name("campaign/writer");

void Message(benchmark::State& state) {
  EndlessDesk endless;
  const std::string text = Pack({*endless.desk().Take(), endless.result()});
  for (auto _ : state) endless.Serve(text);
  state.counters["bytes"] = static_cast<double>(text.size());
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(Message)->Name("campaign/message");

/// A rank that holds one run, and a second one while its message is sent, as MpiSession::Follow does.
struct Rank {
  int waiting = 2;  ///< runs that it holds, including the current one
  double idle_from_s = 0;
};

void Ranks(benchmark::State& state) {
  constexpr double kLatency = 20e-6;  // latency of a TCP message within a cluster [s]
  constexpr std::size_t kRunsPerRank = 10;
  const auto num_ranks = static_cast<std::size_t>(state.range(0));
  EndlessDesk endless;
  const std::string text = Pack({*endless.desk().Take(), endless.result()});
  for (auto _ : state) {
    RandomStream random(1, "durations");
    std::vector<Rank> ranks(num_ranks);
    using Event = std::pair<double, std::size_t>;  // end of a run [s] and its rank
    std::priority_queue<Event, std::vector<Event>, std::greater<>> ends;
    const auto begin_run = [&](double time, std::size_t rank) {
      ends.emplace(time + random.Uniform(0.5, 1.5), rank);
    };
    for (std::size_t rank = 0; rank < num_ranks; ++rank) begin_run(0, rank);

    // Rank 0 handles the messages in the order in which the runs end.
    double free_from = 0, busy = 0, idle = 0;
    std::size_t served = 0;
    std::priority_queue<Event, std::vector<Event>, std::greater<>> replies;
    while (served < kRunsPerRank * num_ranks) {
      if (!replies.empty() && (ends.empty() || replies.top().first < ends.top().first)) {
        const auto [time, rank] = replies.top();
        replies.pop();
        if (++ranks[rank].waiting == 1) {
          idle += time - ranks[rank].idle_from_s;
          begin_run(time, rank);
        }
        continue;
      }
      const auto [end, rank] = ends.top();
      ends.pop();
      const auto begin = std::chrono::steady_clock::now();
      endless.Serve(text);
      const double cost = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
      free_from = std::max(end + kLatency, free_from) + cost;
      busy += cost;
      ++served;
      replies.emplace(free_from + kLatency, rank);
      ranks[rank].idle_from_s = end;
      if (--ranks[rank].waiting > 0) begin_run(end, rank);
    }
    state.counters["runs_per_s"] = static_cast<double>(served) / free_from;
    state.counters["working"] = 1 - idle / (free_from * static_cast<double>(num_ranks));
    state.counters["busy"] = busy / free_from;
  }
}
BENCHMARK(Ranks)
    ->Name("campaign/ranks")
    ->RangeMultiplier(10)
    ->Range(100, 10'000)
    ->Arg(30'000)
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);

void Jobs(benchmark::State& state) {
  constexpr std::size_t kRuns = 40;
  const YamlDocument file = File(kRuns);
  const CampaignPlan plan(file);
  const CampaignRunner runner(plan, file, QuadrupedApp().AsScenarioApp());
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
