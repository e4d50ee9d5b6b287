#include <tenon/systems/live/internal/live_channel.h>

#include <nlohmann/json.hpp>

#include <utility>

namespace tenon::internal {
namespace {

constexpr std::size_t kMaxBytes = 64 << 20;  // maximal size of the history
constexpr std::size_t kMaxRequests = 256;    // maximal number of waiting requests
constexpr std::size_t kMaxStreams = 32;
constexpr std::size_t kChunk = 64 << 10;           // size of a chunk [bytes]
constexpr std::chrono::seconds kSilence(1);        // interval of keep-alive comments
constexpr std::chrono::seconds kAnswerWithin(10);  // timeout for an answer of the run

std::string Event(const std::string& name, const std::string& json) {
  return "event: " + name + "\ndata: " + json + "\n\n";
}

}  // namespace

LiveReply Refusal(int status, const std::string& why) {
  const auto replace = nlohmann::json::error_handler_t::replace;
  return {status, nlohmann::json{{"error", why}}.dump(-1, ' ', false, replace)};
}

void LiveChannel::Set(Latest& latest, std::string text) {
  {
    const std::lock_guard lock(mutex_);
    if (latest.version > 0 && latest.text == text) return;
    latest.text = std::move(text);
    ++latest.version;
  }
  news_.notify_all();
}

void LiveChannel::Begin(std::string hello, std::string names) {
  {
    const std::lock_guard lock(mutex_);
    names_ = std::move(names);
    first_ += messages_.size();
    messages_.clear();
    bytes_ = 0;
    hello_.text = Event("hello", hello);
    ++hello_.version;
  }
  news_.notify_all();
}

void LiveChannel::Push(Message message) {
  {
    const std::lock_guard lock(mutex_);
    bytes_ += message.text.size();
    messages_.push_back(std::move(message));
    const double oldest = messages_.back().time - history_;
    while (messages_.size() > 1 && (bytes_ > kMaxBytes || messages_.front().time < oldest)) {
      bytes_ -= messages_.front().text.size();
      messages_.pop_front();
      ++first_;
    }
  }
  news_.notify_all();
}

void LiveChannel::Append(double time, std::string body) {
  Push({time, true, std::move(body)});
}
void LiveChannel::Say(double time, const std::string& event, const std::string& json) {
  Push({time, false, Event(event, json)});
}

void LiveChannel::Clear() {
  const std::lock_guard lock(mutex_);
  first_ += messages_.size() + 1;  // a gap in the numbering tells every reader to start over
  messages_.clear();
  bytes_ = 0;
}

void LiveChannel::SetStatus(std::string json) {
  Set(status_, Event("status", json));
}
void LiveChannel::SetPull(std::string json) {
  Set(pull_, Event("pull", json));
}

std::optional<LiveRequest> LiveChannel::TakeRequest() {
  const std::lock_guard lock(mutex_);
  if (requests_.empty()) return std::nullopt;
  LiveRequest request = std::move(requests_.front());
  requests_.pop_front();
  return request;
}

void LiveChannel::WaitUntil(std::chrono::steady_clock::time_point time) {
  std::unique_lock lock(mutex_);
  asked_.wait_until(lock, time, [&] { return !requests_.empty() || closed_; });
}

std::size_t LiveChannel::clients() const {
  const std::lock_guard lock(mutex_);
  return num_streams_;
}

bool LiveChannel::IsConnected(const std::string& client) const {
  const std::lock_guard lock(mutex_);
  return streams_.contains(client);
}

void LiveChannel::CountRefused() {
  const std::lock_guard lock(mutex_);
  ++refused_;
}
long LiveChannel::refused() const {
  const std::lock_guard lock(mutex_);
  return refused_;
}

void LiveChannel::Close() {
  {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    requests_.clear();  // waiting readers get a broken promise
  }
  news_.notify_all();
  asked_.notify_all();
}

LiveReply LiveChannel::Ask(const std::string& client, std::string json) {
  std::future<LiveReply> answer;
  {
    const std::lock_guard lock(mutex_);
    if (closed_) return Refusal(503, "the run has ended");
    if (requests_.size() >= kMaxRequests) return Refusal(503, "too many commands are waiting: send fewer");
    requests_.push_back({client, std::move(json), {}});
    answer = requests_.back().reply.get_future();
  }
  asked_.notify_all();
  if (answer.wait_for(kAnswerWithin) != std::future_status::ready)
    return Refusal(503, "the run did not answer in time; it may still execute the command");
  try {
    return answer.get();
  } catch (const std::future_error&) {
    return Refusal(503, "the run has ended");
  }
}

LiveChannel::Reader::Reader(LiveChannel& channel, std::string client)
    : channel_(channel), client_(std::move(client)) {
  const std::lock_guard lock(channel_.mutex_);
  if (channel_.num_streams_ >= kMaxStreams) return;
  admitted_ = true;
  next_ = channel_.first_;
  ++channel_.num_streams_;
  ++channel_.streams_[client_];
}

LiveChannel::Reader::~Reader() {
  if (!admitted_) return;
  const std::lock_guard lock(channel_.mutex_);
  --channel_.num_streams_;
  if (--channel_.streams_[client_] == 0) channel_.streams_.erase(client_);
}

std::string LiveChannel::Reader::Next() {
  LiveChannel& c = channel_;
  std::unique_lock lock(c.mutex_);
  const bool news = c.news_.wait_for(lock, kSilence, [&] {
    return c.closed_ ||
           (c.hello_.version > 0 && (hello_ != c.hello_.version || next_ != c.first_ + c.messages_.size() ||
                                     status_ != c.status_.version || pull_ != c.pull_.version));
  });
  if (c.closed_) return "";
  if (!news) return ": waiting\n\n";
  std::string out;
  const bool new_run = hello_ != c.hello_.version;
  if (new_run || next_ < c.first_) {
    if (hello_ != 0) out += Event("reset", "{}");
    if (new_run) out += c.hello_.text;
    hello_ = c.hello_.version;
    named_ = false;
    next_ = c.first_;
  }
  while (next_ - c.first_ < c.messages_.size() && out.size() < kChunk) {
    const Message& message = c.messages_[next_++ - c.first_];
    if (!message.append) {
      out += message.text;
      continue;
    }
    out += "event: append\ndata: {" + (named_ ? "" : c.names_ + ",") + message.text + "}\n\n";
    named_ = true;
  }
  if (next_ != c.first_ + c.messages_.size()) return out;  // latest values follow after all messages
  if (std::exchange(status_, c.status_.version) != c.status_.version) out += c.status_.text;
  if (std::exchange(pull_, c.pull_.version) != c.pull_.version) out += c.pull_.text;
  return out;
}

}  // namespace tenon::internal
