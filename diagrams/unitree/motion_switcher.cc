#include <tenon/diagrams/unitree/motion_switcher.h>

#include <fmt/core.h>
#include <unitree_api.h>

#include <chrono>
#include <thread>

namespace tenon {
namespace {

using Request = unitree_api_msg_dds__Request_;
using Response = unitree_api_msg_dds__Response_;

constexpr std::int64_t kCheck = 1001, kRelease = 1003;

/// A request, or the answer to it.
struct Call {
  std::int64_t id = 0;  ///< the answer has that of the request
  std::int64_t action = 0;
  int code = 0;         ///< of an answer; 0: done
  bool active = false;  ///< of the answer to kCheck: a built-in mode runs
  static FieldList Fields() {
    return {{"id", &Call::id}, {"action", &Call::action}, {"code", &Call::code}, {"active", &Call::active}};
  }
};

// Texts live as long as the program; Cyclone DDS only reads them.
void WriteRequest(const Call& call, Request& message) {
  message.header.identity = {call.id, call.action};
  message.parameter = const_cast<char*>("{}");
}
std::string ReadRequest(const Request& message, Call& call) {
  call = {message.header.identity.id, message.header.identity.api_id};
  return "";
}

void WriteAnswer(const Call& call, Response& message) {
  message.header.identity = {call.id, call.action};
  message.header.status.code = call.code;
  message.data =
      const_cast<char*>(call.active ? R"({"form":"0","name":"normal"})" : R"({"form":"0","name":""})");
}
std::string ReadAnswer(const Response& message, Call& call) {
  std::string data = message.data == nullptr ? "" : message.data;
  std::erase(data, ' ');
  constexpr std::string_view kName = R"("name":")";
  const std::size_t name = data.find(kName);
  const bool active = name != data.npos && !data.substr(name + kName.size()).starts_with('"');
  call = {message.header.identity.id, message.header.identity.api_id, message.header.status.code, active};
  return "";
}

const auto kRequest =
    MakeDdsMessage<Request, Call, WriteRequest, ReadRequest>(&unitree_api_msg_dds__Request__desc);
const auto kAnswer =
    MakeDdsMessage<Response, Call, WriteAnswer, ReadAnswer>(&unitree_api_msg_dds__Response__desc);

internal::DdsEnd EndOf(const char* topic, const DdsLink& link) {
  return {std::string("rt/api/motion_switcher/") + topic, link, false};
}

}  // namespace

MotionSwitcher::MotionSwitcher(const MotionSwitcherParams& p) : LeafSystem(p) {
  if (params.silent) return;
  requests_ = internal::MakeDdsInbox(EndOf("request", params.link), kRequest, 1);
  answers_ = internal::MakeDdsSender(EndOf("response", params.link), kAnswer);
}

void MotionSwitcher::Answer(bool& active_now) const {
  constexpr int kUnknown = 3203;  // as the robots answer a number that they do not know
  Call call;
  RefusedMessages ignored;
  if (!requests_ || !requests_->Take(0, &call, ignored)) return;
  if (call.action == kRelease) active_now = false;
  if (call.action != kCheck && call.action != kRelease) call.code = kUnknown;
  call.active = active_now;
  std::vector<char> memory;
  answers_->Send(0, &call, memory);
}

bool LeaveBuiltInMode(const DdsLink& link, double patience_s) {
  using Clock = std::chrono::steady_clock;
  using Seconds = std::chrono::duration<double>;
  constexpr Seconds kEach{0.1}, kPause{0.002};
  constexpr int kPatienceOfMode = 5;  // a robot takes seconds to end its mode
  const auto sender = internal::MakeDdsSender(EndOf("request", link), kRequest);
  const auto inbox = internal::MakeDdsInbox(EndOf("response", link), kAnswer, 1);
  std::vector<char> memory;
  const auto begin = Clock::now();
  const auto passed = [&] { return Seconds(Clock::now() - begin).count(); };
  Call request{begin.time_since_epoch().count(), kCheck};
  bool heard = false;
  while (passed() < (heard ? kPatienceOfMode : 1) * patience_s) {
    ++request.id;
    sender->Send(0, &request, memory);
    Call answer;
    RefusedMessages ignored;
    const auto end = Clock::now() + kEach;
    while (Clock::now() < end && (!inbox->Take(0, &answer, ignored) || answer.id != request.id))
      std::this_thread::sleep_for(kPause);
    if (answer.id != request.id) continue;
    heard = true;
    const bool checked = answer.action == kCheck && answer.code == 0;
    if (checked && !answer.active) return true;
    request.action = checked ? kRelease : kCheck;
    if (!checked) std::this_thread::sleep_for(kEach);
  }
  if (!heard && link.interface == "lo") return false;
  throw ParameterError(fmt::format(
      fmt::runtime(heard ? "the robot of domain {} at '{}' keeps its built-in mode: let it lie, and end the "
                           "mode by the maker's app"
                         : "no robot answers in domain {} at '{}': check that it is on, the cable, that this "
                           "machine has an "
                           "address such as 192.168.123.99 there, and the domain, which is 0 on a robot"),
      link.domain, link.interface));
}

}  // namespace tenon
