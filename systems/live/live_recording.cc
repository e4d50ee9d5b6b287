#include <tenon/systems/files/input_file.h>
#include <tenon/systems/live/internal/live_run.h>
#include <tenon/systems/live/live_recording.h>
#include <tenon/systems/text/text.h>
#include <tenon/systems/version.h>

#include <fmt/format.h>

namespace tenon {

using Json = nlohmann::ordered_json;

namespace {

constexpr int kFormat = 1;  // version of the file; it changes whenever Read cannot read earlier files

double FiniteTime(const Json& json, double least) {
  constexpr double kLongest = 1e11;  // some 3000 years [s]
  const double time = json.get<double>();
  if (!(time >= least && time <= kLongest)) throw std::out_of_range("a time goes back");
  return time;
}

void ReadLine(const Json& json, bool first, LiveRecording& recording) {
  if (first) {
    if (json.at("tenon_live") != kFormat) throw std::out_of_range("another format");
    recording.seed = internal::ReadSeed(json.at("seed"));
    return;
  }
  if (recording.end) throw std::out_of_range("a line behind the end");
  const double last = recording.entries.empty() ? 0 : recording.entries.back().time;
  if (json.contains("end")) {
    recording.end = FiniteTime(json.at("end"), last);
    recording.end_tick = json.at("tick").get<bool>();
    return;
  }
  LiveEntry entry{FiniteTime(json.at("time"), last), {}};
  for (const auto& [path, values] : json.at("set").items())
    entry.sets.push_back({path, values.get<std::vector<double>>()});
  recording.entries.push_back(std::move(entry));
}

std::string EntryLine(const LiveEntry& entry) {
  Json sets = Json::object();
  for (const LiveSet& set : entry.sets) sets[set.path] = set.values;
  return Json{{"time", entry.time}, {"set", std::move(sets)}}.dump();
}

}  // namespace

LiveRecording LiveRecording::Read(const std::filesystem::path& file) {
  std::ifstream in = OpenInput(file);
  if (!in.is_open())
    throw ParameterError(
        fmt::format("cannot read the recording '{}': give the live.jsonl of a live run", file.string()));
  LiveRecording recording;
  std::string line;
  int number = 0;
  while (std::getline(in, line)) {
    if (++number == 1 && line.starts_with("\xEF\xBB\xBF")) line.erase(0, 3);  // a byte-order mark
    try {
      ReadLine(Json::parse(line), number == 1, recording);
    } catch (const std::exception&) {
      if (in.eof() && number > 1 && !recording.end) break;  // the run was killed while writing
      throw ParameterError(
          fmt::format("{}:{}: {} is not a line of a recording: give the live.jsonl of a live run",
                      file.string(), number, internal::Excerpt(line)));
    }
  }
  if (number == 0) throw ParameterError(fmt::format("{}:1: the recording is empty", file.string()));
  return recording;
}

RunStatus Replay(Simulator& simulator, const LiveRecording& recording, std::optional<double> duration) {
  RunStatus status = simulator.Initialize();
  for (const LiveEntry& entry : recording.entries) {
    if (status.ended || (duration && entry.time >= *duration)) break;
    status = simulator.AdvanceToBefore(entry.time);
    if (status.ended) break;
    try {
      internal::ApplyEntry(simulator.context(), entry);
    } catch (const Error& error) {
      throw ParameterError(
          fmt::format("the recording cannot be replayed at t = {} s: {}", entry.time, error.what()));
    }
  }
  if (status.ended) return status;
  if (duration && !(recording.end && *recording.end < *duration)) return simulator.AdvanceTo(*duration);
  if (!recording.end)
    throw ParameterError("the recording has no end, because the run was killed: give a duration");
  return recording.end_tick ? simulator.AdvanceTo(*recording.end) : simulator.AdvanceToBefore(*recording.end);
}

namespace internal {

void ApplyEntry(Context& context, const LiveEntry& entry) {
  for (const LiveSet& set : entry.sets) context.SetDoubles(context.diagram().Find(set.path), set.values);
}

LiveFile::LiveFile(std::filesystem::path file, std::uint64_t seed) : file_(std::move(file)) {
  recording_.seed = seed;
  Rewrite();
}

void LiveFile::Rewrite() {
  if (file_.empty()) return;
  out_ = std::ofstream(file_, std::ios::trunc);
  Line(Json{{"tenon_live", kFormat}, {"seed", recording_.seed}, {"tenon", Version()}}.dump());
  for (const LiveEntry& entry : recording_.entries) Line(EntryLine(entry));
}

void LiveFile::Line(const std::string& text) {
  if (file_.empty()) return;
  out_ << text << std::endl;
  if (!out_)
    throw OutputError(fmt::format("cannot write '{}': check the disk and the directory", file_.string()));
}

void LiveFile::Add(LiveEntry entry) {
  Line(EntryLine(entry));
  recording_.entries.push_back(std::move(entry));
}

void LiveFile::DropFrom(double time) {
  auto& entries = recording_.entries;
  const std::size_t before = entries.size();
  while (!entries.empty() && entries.back().time >= time) entries.pop_back();
  if (entries.size() != before) Rewrite();
}

void LiveFile::End(double time, bool tick) {
  Line(Json{{"end", time}, {"tick", tick}}.dump());
}

}  // namespace internal
}  // namespace tenon
