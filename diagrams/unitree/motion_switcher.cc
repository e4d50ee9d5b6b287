#include <tenon/diagrams/unitree/motion_switcher.h>

#include <fmt/core.h>
#include <unitree_api.h>

#include <chrono>
#include <thread>

namespace tenon {
namespace {

using Request = unitree_api_msg_dds__Request_;
using Response = unitree_api_msg_dds__Response_;

/// A text that lives as long as the program; Cyclone DDS only reads it.
char* Text(const char* text) {
  return const_cast<char*>(text);
}

void WriteRequest(const SwitcherRequest& request, Request& message) {
  message.header.identity = {request.id, request.action};
  message.parameter = Text("{}");
}
std::string ReadRequest(const Request& message, SwitcherRequest& request) {
  request = {message.header.identity.id, message.header.identity.api_id};
  return "";
}

void WriteAnswer(const SwitcherAnswer& answer, Response& message) {
  message.header.identity = {answer.id, answer.action};
  message.header.status.code = answer.code;
  message.data = Text(answer.active ? R"({"form":"0","name":"normal"})" : R"({"form":"0","name":""})");
}
std::string ReadAnswer(const Response& message, SwitcherAnswer& answer) {
  std::string data = message.data == nullptr ? "" : message.data;
  std::erase(data, ' ');
  constexpr std::string_view kName = R"("name":")";
  const std::size_t name = data.find(kName);
  const bool active = name != data.npos && !data.substr(name + kName.size()).starts_with('"');
  answer = {message.header.identity.id, message.header.identity.api_id, message.header.status.code, active};
  return "";
}

}  // namespace

const DdsMessage& DdsMessageOf<SwitcherRequest>::Get() {
  static const auto kMessage = MakeDdsMessage<Request, SwitcherRequest, WriteRequest, ReadRequest>(
      &unitree_api_msg_dds__Request__desc);
  return kMessage;
}

const DdsMessage& DdsMessageOf<SwitcherAnswer>::Get() {
  static const auto kMessage =
      MakeDdsMessage<Response, SwitcherAnswer, WriteAnswer, ReadAnswer>(&unitree_api_msg_dds__Response__desc);
  return kMessage;
}

void MotionSwitcher::Answer(bool& active_now) const {
  constexpr int kUnknown = 3203;  // as the robots answer a number that they do not know
  SwitcherRequest request;
  RefusedMessages ignored;
  if (!inbox_ || !inbox_->Take(0, &request, ignored)) return;
  if (request.action == SwitcherRequest::kRelease) active_now = false;
  const bool known = request.action == SwitcherRequest::kRelease || request.action == SwitcherRequest::kCheck;
  const SwitcherAnswer given{request.id, request.action, known ? 0 : kUnknown, active_now};
  std::vector<char> memory;
  sender_->Send(0, &given, memory);
}

bool LeaveBuiltInMode(const DdsLink& link, double patience_s) {
  using Clock = std::chrono::steady_clock;
  using Seconds = std::chrono::duration<double>;
  constexpr Seconds kEach{0.1}, kPause{0.002};
  constexpr int kPatienceOfMode = 5;  // a robot takes seconds to end its mode
  const std::string prefix = "rt/api/motion_switcher/";
  const auto sender =
      internal::MakeDdsSender({prefix + "request", link, false}, DdsMessageOf<SwitcherRequest>::Get());
  const auto inbox =
      internal::MakeDdsInbox({prefix + "response", link, false}, DdsMessageOf<SwitcherAnswer>::Get(), 1);
  std::vector<char> memory;
  const auto begin = Clock::now();
  const auto passed = [&] { return Seconds(Clock::now() - begin).count(); };
  SwitcherRequest request{begin.time_since_epoch().count(), SwitcherRequest::kCheck};
  bool heard = false;
  while (passed() < (heard ? kPatienceOfMode : 1) * patience_s) {
    ++request.id;
    sender->Send(0, &request, memory);
    SwitcherAnswer answer;
    RefusedMessages ignored;
    const auto end = Clock::now() + kEach;
    while (Clock::now() < end && (!inbox->Take(0, &answer, ignored) || answer.id != request.id))
      std::this_thread::sleep_for(kPause);
    if (answer.id != request.id) continue;
    heard = true;
    const bool checked = answer.action == SwitcherRequest::kCheck && answer.code == 0;
    if (checked && !answer.active) return true;
    request.action = checked ? SwitcherRequest::kRelease : SwitcherRequest::kCheck;
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
