#include <tenon/apps/campaign/campaign_mpi.h>

#include <nlohmann/json.hpp>

#ifdef TENON_WITH_MPI
#include <mpi.h>
#endif

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
      "use "
      "--jobs without mpirun");
}
MpiSession::~MpiSession() = default;
void MpiSession::Lead(CampaignDesk&, const CampaignRunner&, int) {}
void MpiSession::Follow(const CampaignRunner&) {}
void MpiSession::Abort(int exit_code) {
  std::_Exit(exit_code);
}

#endif

}  // namespace tenon::apps
