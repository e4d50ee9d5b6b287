#include <tenon/apps/campaign/campaign_desk.h>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#ifdef TENON_WITH_MPI
#include <mpi.h>
#endif

namespace tenon::apps {

CampaignDesk::CampaignDesk(CampaignSchedule& schedule, CampaignTable& table, std::size_t done)
    : schedule_(schedule), table_(table), before_(done) {}

bool CampaignDesk::closed() {
  const std::lock_guard lock(mutex_);
  return Stopped() || schedule_.finished();
}

std::optional<std::size_t> CampaignDesk::Take() {
  std::unique_lock lock(mutex_);
  while (true) {
    if (Stopped()) return {};
    if (const auto run = schedule_.Next()) return run;
    if (schedule_.finished()) return {};
    changed_.wait_for(lock, std::chrono::milliseconds(100));  // a signal does not notify
  }
}

std::optional<std::size_t> CampaignDesk::TryTake() {
  const std::lock_guard lock(mutex_);
  if (Stopped()) return {};
  return schedule_.Next();
}

void CampaignDesk::Put(std::size_t run, const std::optional<CampaignResult>& result) {
  const std::lock_guard lock(mutex_);
  if (!result) {  // a signal stopped it, here or on another machine
    interrupted_ = true;
    changed_.notify_all();
    return;
  }
  if (!result->machine_failure.empty()) {
    constexpr std::size_t kMostInARow = 10;
    ++lost_;
    why_lost_ = result->machine_failure;
    const bool can_go_on = schedule_.Lost(run) && ++lost_in_a_row_ < kMostInARow;
    if (!can_go_on && !failure_)
      failure_ = std::make_exception_ptr(OutputError(
          fmt::format("run {} cannot be completed on this machine: {}; mend that, and continue with --resume",
                      run, why_lost_)));
    changed_.notify_all();
    return;
  }
  lost_in_a_row_ = 0;
  try {
    if (!failure_) table_.Append(result->row);
  } catch (...) {
    failure_ = std::current_exception();
  }
  schedule_.Done(run, result->survived);
  ++ended_;
  failures_ += result->survived ? 0 : 1;
  if (line_.due()) line_.Show(Share(), Text());
  changed_.notify_all();
}

void CampaignDesk::Close() {
  const std::lock_guard lock(mutex_);
  line_.End(Share(), Text());
  if (failure_) std::rethrow_exception(failure_);
}

std::optional<double> CampaignDesk::Share() const {
  const auto total = schedule_.total();
  if (!total) return {};
  return *total == 0 ? 1 : static_cast<double>(before_ + ended_) / static_cast<double>(*total);
}

std::string CampaignDesk::Text() const {
  const double wall = line_.elapsed();
  const double rate = wall > 0 ? static_cast<double>(ended_) / wall : 0;
  const std::size_t done = before_ + ended_;
  const auto total = schedule_.total();
  if (!total) return fmt::format("{} runs, {:.1f} a second, {} failed", done, rate, failures_);
  const double left = rate > 0 ? static_cast<double>(*total - std::min(done, *total)) / rate : 0;
  return fmt::format("{} of {} runs, {:.1f} a second, {:.0f} s left, {} failed", done, *total, rate, left,
                     failures_);
}

void WorkInThreads(CampaignDesk& desk, const CampaignRunner& runner, int jobs) {
  const auto work = [&] {
    while (const auto run = desk.Take()) desk.Put(*run, runner.Run(*run));
  };
  std::vector<std::jthread> others;
  try {
    for (int i = 1; i < jobs; ++i) others.emplace_back(work);
  } catch (const std::system_error& error) {
    Say(fmt::format("warning: running only {} jobs at a time: {}\n", others.size() + 1, error.what()));
  }
  work();
}

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

bool StartedByMpi() {
  for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMIX_RANK", "PMI_SIZE"})
    if (std::getenv(name) != nullptr) return true;
  return false;
}

#ifdef TENON_WITH_MPI

namespace {

// Tags of messages to rank 0 (a row, a request for a run) and from rank 0 (a run, or kNoMore).
constexpr int kRow = 1, kWanted = 2, kRun = 3;
constexpr long long kNoMore = -1;

void Give(long long run, int rank) {
  MPI_Send(&run, 1, MPI_LONG_LONG, rank, kRun, MPI_COMM_WORLD);
}

}  // namespace

MpiSession::MpiSession() {
  int provided = 0;
  MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &provided);
  MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
  MPI_Comm_size(MPI_COMM_WORLD, &size_);
}

MpiSession::~MpiSession() {
  MPI_Finalize();
}

void MpiSession::Lead(CampaignDesk& desk, const CampaignRunner& runner, int jobs) {
  std::jthread own([&] { WorkInThreads(desk, runner, jobs); });
  std::deque<int> waiting;  // ranks, once for each requested run
  // Each other rank requests two runs at the start and one more with each row.
  int open = 2 * (size_ - 1);  // requests that kNoMore has not answered yet
  while (open > 0) {
    int there = 0;
    MPI_Status status;
    MPI_Iprobe(MPI_ANY_SOURCE, MPI_ANY_TAG, MPI_COMM_WORLD, &there, &status);
    if (there != 0) {
      int size = 0;
      MPI_Get_count(&status, MPI_CHAR, &size);
      std::string text(static_cast<std::size_t>(size), '\0');
      MPI_Recv(text.data(), size, MPI_CHAR, status.MPI_SOURCE, status.MPI_TAG, MPI_COMM_WORLD,
               MPI_STATUS_IGNORE);
      if (status.MPI_TAG == kRow) {
        const CampaignMessage message = Unpack(text);
        desk.Put(message.run, message.result);
      }
      waiting.push_back(status.MPI_SOURCE);
    }
    bool gave = false;
    while (!waiting.empty()) {
      if (const auto run = desk.TryTake()) {
        Give(static_cast<long long>(*run), waiting.front());
      } else if (desk.closed()) {
        Give(kNoMore, waiting.front());
        --open;
      } else {
        break;
      }
      waiting.pop_front();
      gave = true;
    }
    // A blocking receive would keep a core busy.
    if (there == 0 && !gave) std::this_thread::sleep_for(std::chrono::microseconds(300));
  }
}

void MpiSession::Follow(const CampaignRunner& runner) {
  const auto ask = [] { MPI_Send(nullptr, 0, MPI_CHAR, 0, kWanted, MPI_COMM_WORLD); };
  ask();
  ask();
  for (int open = 2; open > 0;) {
    int there = 0;
    while (MPI_Iprobe(0, kRun, MPI_COMM_WORLD, &there, MPI_STATUS_IGNORE) == MPI_SUCCESS && there == 0)
      std::this_thread::sleep_for(std::chrono::microseconds(300));
    long long run = kNoMore;
    MPI_Recv(&run, 1, MPI_LONG_LONG, 0, kRun, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
    if (run == kNoMore) {
      --open;
      continue;
    }
    const auto at = static_cast<std::size_t>(run);
    const std::string text = Pack({at, runner.Run(at)});
    MPI_Send(text.data(), static_cast<int>(text.size()), MPI_CHAR, 0, kRow, MPI_COMM_WORLD);
  }
}

void MpiSession::Abort(int exit_code) {
  MPI_Abort(MPI_COMM_WORLD, exit_code);
  std::_Exit(exit_code);
}

#else

MpiSession::MpiSession() {
  throw ParameterError(
      "mpirun started a program that was built without MPI: apt-get install libopenmpi-dev and rebuild, or "
      "use --jobs without mpirun");
}
MpiSession::~MpiSession() = default;
void MpiSession::Lead(CampaignDesk&, const CampaignRunner&, int) {}
void MpiSession::Follow(const CampaignRunner&) {}
void MpiSession::Abort(int exit_code) {
  std::_Exit(exit_code);
}

#endif

}  // namespace tenon::apps
