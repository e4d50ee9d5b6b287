#include <tenon/systems/live/internal/live_run.h>
#include <tenon/systems/text/text.h>

#include <fmt/format.h>

namespace tenon::internal {
namespace {

/// A command that is valid but not possible at present.
struct NotNow {
  int status;
  std::string why;
};

/// Time after which a driver without a stream of events loses control.
constexpr std::chrono::seconds kDriverWaits(5);

double Number(const Json& command, const char* key) {
  const Json& value = command.at(key);
  if (!value.is_number() || !std::isfinite(value.get<double>()))
    throw ParameterError(fmt::format("'{}' must be a number", key));
  return value.get<double>();
}

Vec<3> Point(const Json& command, const char* key) {
  const Json& value = command.at(key);
  if (!value.is_array() || value.size() != 3)
    throw ParameterError(fmt::format("'{}' must be three numbers", key));
  Vec<3> point;
  for (std::size_t i = 0; i < 3; ++i) {
    if (!value[i].is_number() || !std::isfinite(value[i].get<double>()))
      throw ParameterError(fmt::format("'{}' must be three numbers", key));
    point[static_cast<Eigen::Index>(i)] = value[i].get<double>();
  }
  return point;
}

template <class Control>
const Control& Have(const std::optional<Control>& control, const std::string& what) {
  if (!control) throw ParameterError(fmt::format("this run has no '{}'", what));
  return *control;
}

LiveSets Choose(const LiveControls::Choice& choice, const std::string& name) {
  const auto found = std::ranges::find(choice.names, name);
  if (found != choice.names.end()) return choice.set(static_cast<std::size_t>(found - choice.names.begin()));
  throw ParameterError(
      fmt::format("there is no '{}'; did you mean '{}'?", name, NearestName(name, choice.names)));
}

void DemandWithin(const char* what, double value, const std::array<double, 2>& range, const char* unit) {
  if (value >= range[0] && value <= range[1]) return;
  throw ParameterError(fmt::format("{} = {} {}: give {} to {}", what, value, unit, range[0], range[1]));
}

}  // namespace

void LiveRun::ServeRequests() {
  while (auto request = channel_.TakeRequest()) {
    LiveReply reply;
    try {
      reply = Execute(request->client, request->json);
    } catch (...) {
      request->reply.set_value(Refusal(500, "the run failed"));
      throw;
    }
    request->reply.set_value(std::move(reply));
  }
}

LiveReply LiveRun::Execute(const std::string& client, const std::string& json) {
  const Json command = Json::parse(json, nullptr, false);
  if (!command.is_object() || !command.contains("command") || !command["command"].is_string())
    return Refusal(400, R"(a command must be an object: {"command": "pause"})");
  try {
    Json answer = Do(client, command);
    answer["ok"] = true;
    return {200, Dump(answer)};
  } catch (const NotNow& refused) {
    return Refusal(refused.status, refused.why);
  } catch (const OutputError&) {
    throw;  // an error of writing the recording ends the run
  } catch (const Error& error) {
    return Refusal(400, error.what());
  } catch (const Json::exception&) {
    return Refusal(400, fmt::format("the command '{}' lacks a value or has one of the wrong type",
                                    command["command"].get<std::string>()));
  }
}

bool LiveRun::HasDriver() const {
  return !driver_.empty() && (channel_.IsConnected(driver_) || Clock::now() - driver_seen_ < kDriverWaits);
}

void LiveRun::DemandDriver(const std::string& client) {
  if (HasDriver() && driver_ == client) {
    driver_seen_ = Clock::now();
    return;
  }
  throw NotNow{403, HasDriver() ? fmt::format("'{}' drives", driver_) : "nobody drives: take it first"};
}

/// Sets the commands of a driver whose page has closed to zero, because a key may have been held.
void LiveRun::LetGoIfAbandoned() {
  const bool listens = channel_.IsConnected(driver_);
  if (driver_listens_ && !listens) {
    LetGo();
    SayEvent("the driver is gone");
  }
  driver_listens_ = listens;
}

void LiveRun::LetGo() {
  if (state_ == State::kEnded) return;
  if (drives_) Apply(view_.controls.drive->set(Vec<3>::Zero()));
  if (pulls_) Apply(view_.controls.pull->release());
  drives_ = pulls_ = false;
}

/// Returns whether the last command that set all paths of `release` was another one.
bool LiveRun::IsHeld(const LiveSets& release) const {
  const auto sets_the_same = [&](const LiveEntry& entry) {
    return std::ranges::equal(entry.sets, release, {}, &LiveSet::path, &LiveSet::path);
  };
  bool held = false;
  for (const LiveEntry& entry : file_.entries()) {
    if (sets_the_same(entry))
      held = !std::ranges::equal(entry.sets, release, {}, &LiveSet::values, &LiveSet::values);
  }
  return held;
}

Json LiveRun::Do(const std::string& client, const Json& command) {
  const auto name = command.at("command").get<std::string>();
  if (name == "take") {
    if (HasDriver() && driver_ != client && !command.value("force", false))
      throw NotNow{403, fmt::format("'{}' drives", driver_)};
    driver_ = client;
    driver_seen_ = Clock::now();
    driver_listens_ = channel_.IsConnected(driver_);
    PublishStatus();
    return Json::object();
  }
  DemandDriver(client);
  Json answer = Json::object();
  if (name == "leave") {
    LetGo();
    driver_.clear();
    driver_listens_ = false;
  } else if (name == "pause") {
    if (state_ == State::kEnded) throw NotNow{409, "the run has ended"};
    state_ = State::kPaused;
  } else if (name == "resume") {
    if (state_ == State::kEnded) throw NotNow{409, "the run has ended: set it back first"};
    state_ = State::kRunning;
    RestartClock();
  } else if (name == "tick") {
    Tick();
  } else if (name == "rate") {
    const double rate = command.at("value").is_null() ? 0 : Number(command, "value");
    if (rate != 0 || !command.at("value").is_null()) DemandWithin("rate", rate, {0.001, 1000}, "");
    wanted_rate_ = rate;
    RestartClock();
  } else if (name == "back") {
    Back(Number(command, "to_s"));
  } else if (name == "reset") {
    Reset(ReadSeed(command.at("seed")));
  } else if (name == "save") {
    answer["yaml"] = SaveScenario();
  } else if (name == "stop") {
    stop_ = true;
  } else if (name == "parameter") {
    SetParameter(command);
  } else {
    Steer(command, name);
  }
  PublishStatus();
  return answer;
}

void LiveRun::Steer(const Json& command, const std::string& name) {
  const LiveControls& controls = view_.controls;
  if (state_ == State::kEnded) throw NotNow{409, "the run has ended: set it back first"};
  if (name == "drive") {
    const auto& drive = Have(controls.drive, name);
    const Vec<3> velocity = Point(command, "velocity");
    DemandWithin("velocity[0]", velocity[0], drive.forward, "m/s");
    DemandWithin("velocity[1]", velocity[1], drive.sideways, "m/s");
    DemandWithin("velocity[2]", velocity[2], drive.yaw, "rad/s");
    Apply(drive.set(velocity));
    drives_ = true;
  } else if (name == "gait") {
    Apply(Choose(Have(controls.gaits, name), command.at("name")));
  } else if (name == "posture") {
    Apply(Choose(Have(controls.postures, name), command.at("name")));
  } else if (name == "goal") {
    const auto& goal = Have(controls.goal, name);
    const Vec<3> position = Point(command, "position");
    for (int i = 0; i < 3; ++i)
      DemandWithin(fmt::format("position[{}]", i).c_str(), position[i], {goal.box_W[0][i], goal.box_W[1][i]},
                   "m");
    Apply(goal.set(context(), position));
  } else if (name == "pull") {
    const auto& pull = Have(controls.pull, name);
    const auto shape = command.at("shape").get<std::size_t>();
    const auto body = pull.bodies.find(shape);
    if (body == pull.bodies.end()) throw ParameterError(fmt::format("shape {} cannot be pulled", shape));
    const Vec<3> target = Point(command, "target_W");
    Apply(pull.set(context(), shape, Point(command, "point_W"), target, !pulls_));
    pulls_ = true;
    pull_ = {{"body", body->second}, {"target_W", {target[0], target[1], target[2]}}};
  } else if (name == "release") {
    Apply(Have(controls.pull, name).release());
    pulls_ = false;
  } else if (name == "load") {
    const auto& load = Have(controls.load, name);
    const double mass = Number(command, "mass_kg");
    if (mass != 0) DemandWithin("mass_kg", mass, load.mass, "kg");
    Apply(load.set(context(), mass));
    SayEvent(mass == 0 ? load.name + " off" : fmt::format("{} of {:.3g} kg", load.name, mass));
  } else {
    static const std::vector<std::string> kCommands{
        "take", "leave",     "pause", "resume", "tick",    "rate", "back", "reset",   "save",
        "stop", "parameter", "drive", "gait",   "posture", "goal", "pull", "release", "load"};
    throw ParameterError(fmt::format("there is no command '{}'; did you mean '{}'?", Excerpt(name),
                                     NearestName(name, kCommands)));
  }
}

/// Applies all changes or none.
void LiveRun::Apply(LiveSets sets) {
  LiveEntry entry{time(), std::move(sets)}, before{time(), {}};
  for (const LiveSet& set : entry.sets)
    before.sets.push_back({set.path, context().EvalDoubles(context().diagram().Find(set.path))});
  try {
    ApplyEntry(context(), entry);
  } catch (const Error&) {
    ApplyEntry(context(), before);
    throw;
  }
  file_.Add(std::move(entry));
}

void LiveRun::SetParameter(const Json& command) {
  const auto path = command.at("path").get<std::string>();
  std::vector<std::string> paths;
  for (const ParameterSource* parameter : parameters_) paths.push_back(parameter->path());
  const auto found = std::ranges::find(paths, path);
  if (found == paths.end())
    throw ParameterError(
        fmt::format("there is no parameter '{}'; did you mean '{}'?", path, NearestName(path, paths)));
  const ParameterSource& parameter = *parameters_[static_cast<std::size_t>(found - paths.begin())];
  const Json& value = command.at("value");
  std::vector<double> values;
  if (value.is_array()) {
    values = value.get<std::vector<double>>();
  } else if (value.is_boolean()) {
    values = {value.get<bool>() ? 1.0 : 0.0};
  } else {
    values = {Number(command, "value")};
  }
  Apply({{path, values}});
  tuned_.insert(path);
  SayChangedParameters();
  SayEvent(fmt::format("{} = {}", path, Dump(ParameterValue(parameter, context()))));
}

/// Sends all Parameters whose values differ from those that the pages show.
void LiveRun::SayChangedParameters() {
  for (std::size_t i = 0; i < parameters_.size(); ++i) {
    Json value = ParameterValue(*parameters_[i], context());
    if (value == shown_[i]) continue;
    shown_[i] = std::move(value);
    channel_.Say(time(), "parameter", Dump({{"path", parameters_[i]->path()}, {"value", shown_[i]}}));
  }
}

void LiveRun::SayEvent(const std::string& label) {
  channel_.Append(time(), "\"events\":" + Dump(Json::array({{{"time", time()}, {"label", label}}})));
}

void LiveRun::Tick() {
  if (state_ == State::kEnded) throw NotNow{409, "the run has ended: set it back first"};
  state_ = State::kPaused;
  const double next = simulator_.next_tick_time();
  if (std::isfinite(next)) {
    Advance(next, true);
    if (state_ != State::kEnded) Advance(simulator_.next_tick_time());
  } else {
    Advance(NextFrame());
  }
  Publish(true);
}

std::string LiveRun::SaveScenario() {
  if (!view_.save) throw ParameterError("this run has no scenario to save");
  LiveSets sets;
  for (const ParameterSource* parameter : parameters_) {
    if (tuned_.contains(parameter->path()))
      sets.push_back({parameter->path(), context().EvalDoubles(*parameter)});
  }
  return view_.save(sets);
}

}  // namespace tenon::internal
