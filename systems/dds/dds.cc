#include <tenon/systems/dds/dds.h>
#include <tenon/systems/dds/internal/c_struct.h>

#include <dds/dds.h>
#include <fmt/core.h>
#include <net/if.h>

#include <atomic>
#include <cstdio>

namespace tenon::internal {
namespace {

/// Capacity of a reader's queue, and in lock-step of a writer's history for readers that start later
/// [messages].
constexpr int kHistory = 64;
constexpr dds_duration_t kPatience = DDS_SECS(10);  // of a sender in lock-step
constexpr double kNanosecond = 1e-9;

/// The log of Cyclone DDS, also of its own threads. It drops messages that it cannot decode, which
/// only its log tells.
class CycloneLog {
 public:
  /// Returns the number of messages of a topic and type that could not be decoded.
  static std::atomic<int>& Undecodable(const std::string& topic, const char* type) {
    const std::lock_guard lock(mutex_);
    return undecodable_[topic + '/' + type];
  }
  /// Keeps the last report in `text`, until it is called with null.
  static void Catch(std::string* text) {
    dds_set_log_sink(Sink, nullptr);
    const std::lock_guard lock(mutex_);
    caught_ = text;
  }

 private:
  static void Sink(void*, const dds_log_data_t* report) noexcept {
    const std::string_view text(report->message, report->size);
    constexpr std::string_view kCannotDecode = "deserialization ";
    const std::lock_guard lock(mutex_);
    if (const auto at = text.find(kCannotDecode); at != text.npos) {
      for (auto& [name, count] : undecodable_)
        if (const auto topic = text.substr(at + kCannotDecode.size());
            topic.starts_with(name) && topic.substr(name.size()).starts_with(' '))
          ++count;
    } else if (caught_ != nullptr) {
      *caught_ = text.substr(0, text.find('\n'));
    } else {
      std::fwrite(text.data(), 1, text.size(), stderr);
    }
  }
  inline static std::mutex mutex_;
  inline static std::map<std::string, std::atomic<int>> undecodable_;
  inline static std::string* caught_ = nullptr;
};

/// The loopback interface has no multicast, so participants there are found by their ports.
std::string ConfigurationFor(const std::string& interface) {
  const bool loopback = interface == "lo";
  return fmt::format(
      "<CycloneDDS><Domain><General><Interfaces><NetworkInterface name=\"{}\"{}/></Interfaces></General>{}"
      "</Domain></CycloneDDS>",
      interface, loopback ? " multicast=\"false\"" : "",
      loopback ? "<Discovery><ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>32"
                 "</MaxAutoParticipantIndex><Peers><Peer address=\"localhost\"/></Peers></Discovery>"
               : "");
}

/// A share in the program's only participant of a domain. The last one leaves the domain.
class Participant {
 public:
  explicit Participant(const DdsLink& link) : domain_(link.domain) {
    Demand(domain_ >= 0 && domain_ <= 230, fmt::format("domain = {} must be 0 to 230", domain_));
    Demand(link.interface.empty() || if_nametoindex(link.interface.c_str()) != 0,
           fmt::format("interface = '{}': this machine has no such network interface; `ip link` lists them",
                       link.interface));
    const std::lock_guard lock(mutex_);
    Joined& joined = Domains()[domain_];
    Demand(
        joined.shares == 0 || joined.interface == link.interface,
        fmt::format("interface = '{}': this program uses domain {} at '{}'; give all of its blocks the same "
                    "interface, or another domain",
                    link.interface, domain_, joined.interface));
    if (joined.shares == 0) joined = Join(link);
    ++joined.shares;
    participant_ = joined.participant;
  }
  ~Participant() {
    const std::lock_guard lock(mutex_);
    Joined& joined = Domains()[domain_];
    if (--joined.shares > 0) return;
    dds_delete(joined.participant);
    if (joined.domain > 0) dds_delete(joined.domain);
  }
  Participant(const Participant&) = delete;
  Participant& operator=(const Participant&) = delete;

  dds_entity_t get() const { return participant_; }

 private:
  struct Joined {
    int shares = 0;
    std::string interface;
    dds_entity_t domain = 0, participant = 0;
  };

  static Joined Join(const DdsLink& link) {
    std::string report;
    CycloneLog::Catch(&report);
    Joined joined{0, link.interface};
    const auto id = static_cast<dds_domainid_t>(link.domain);
    if (!link.interface.empty())
      joined.domain = dds_create_domain(id, ConfigurationFor(link.interface).c_str());
    if (joined.domain >= 0) joined.participant = dds_create_participant(id, nullptr, nullptr);
    CycloneLog::Catch(nullptr);
    const dds_return_t error = std::min(joined.domain, joined.participant);
    if (error >= 0) return joined;
    if (joined.domain > 0) dds_delete(joined.domain);
    throw ParameterError(fmt::format(
        "cannot join domain {} at interface '{}': {} ({}); check that the interface is up and has an "
        "address, and CYCLONEDDS_URI",
        link.domain, link.interface, dds_strretcode(error), report));
  }
  static std::map<int, Joined>& Domains() {
    static std::map<int, Joined> domains;
    return domains;
  }
  inline static std::mutex mutex_;

  const int domain_;
  dds_entity_t participant_ = 0;
};

/// The defaults of DDS with the history of a writer, or in lock-step a reader and a writer that lose nothing
/// and may start in any order.
class QualityOfService {
 public:
  explicit QualityOfService(const DdsEnd& end, int depth) {
    if (end.lock_step) {
      dds_qset_reliability(get(), DDS_RELIABILITY_RELIABLE, kPatience);
      dds_qset_history(get(), DDS_HISTORY_KEEP_ALL, 0);
      depth = kHistory;  // for readers that start later
    } else {
      dds_qset_history(get(), DDS_HISTORY_KEEP_LAST, depth);
      if (!end.transient_local) return;
    }
    dds_qset_durability(get(), DDS_DURABILITY_TRANSIENT_LOCAL);
    dds_qset_durability_service(get(), 0, DDS_HISTORY_KEEP_LAST, depth, DDS_LENGTH_UNLIMITED,
                                DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED);
  }
  dds_qos_t* get() const { return quality_.get(); }

 private:
  std::unique_ptr<dds_qos_t, void (*)(dds_qos_t*)> quality_{dds_create_qos(), dds_delete_qos};
};

/// Owns a reader or a writer and what belongs to it.
struct OwnedEntity {
  const dds_entity_t entity;
  explicit OwnedEntity(dds_entity_t made) : entity(made) {
    if (made < 0)
      throw RunError(fmt::format("Cyclone DDS refuses a reader or writer: {}", dds_strretcode(made)));
  }
  ~OwnedEntity() { dds_delete(entity); }
  OwnedEntity(const OwnedEntity&) = delete;
  OwnedEntity& operator=(const OwnedEntity&) = delete;
};

/// The common part of readers and writers.
struct End {
  End(const DdsEnd& at, const DdsMessage& of)
      : end(at), message(of), participant(at.link), topic(MakeTopic()) {}

  dds_entity_t MakeTopic() const {
    const auto* type = static_cast<const dds_topic_descriptor_t*>(message.descriptor);
    Demand(!end.topic.empty(), "topic is empty: set the name of the topic, such as \"rt/lowcmd\"");
    Demand(type->m_size == message.size,
           fmt::format("the type {} is not that of its descriptor", type->m_typename));
    if (message.as_is != nullptr) {
      const std::string name = ros2::DdsNameOf(*message.as_is);
      Demand(name == type->m_typename && SizeOfC(*message.as_is) == type->m_size,
             fmt::format("the type {} is not that of the signal {}: give both the same members, and the "
                         "signal the package as its namespace",
                         type->m_typename, name));
    }
    const dds_entity_t made = dds_create_topic(participant.get(), type, end.topic.c_str(), nullptr, nullptr);
    Demand(made > 0,
           fmt::format("topic = '{}' cannot be made with the type {}: {}; it must be a name of letters, "
                       "digits, '/' and '_' that has one type in this program",
                       end.topic, type->m_typename, dds_strretcode(made)));
    return made;
  }

  const DdsEnd end;
  const DdsMessage message;
  const Participant participant;
  const OwnedEntity topic;
};

class DdsInbox final : public Inbox {
 public:
  DdsInbox(const DdsEnd& end, const DdsMessage& message, double timeout_s)
      : Inbox({end.lock_step, timeout_s}),
        end_(end, message),
        undecodable_(CycloneLog::Undecodable(
            end.topic, static_cast<const dds_topic_descriptor_t*>(message.descriptor)->m_typename)),
        reader_(MakeReader()),
        ready_(dds_create_readcondition(reader_.entity, DDS_ANY_STATE)),
        waiting_(dds_create_waitset(end_.participant.get())),
        memory_(message.size) {
    dds_waitset_attach(waiting_.entity, ready_.entity, 0);
    if (message.as_is != nullptr) candidate_.emplace(*message.as_is, std::byte{0});
  }
  ~DdsInbox() override { Free(); }

 private:
  dds_entity_t MakeReader() const {
    const QualityOfService quality(end_.end, kHistory);
    return dds_create_reader(end_.participant.get(), end_.topic.entity, quality.get(), nullptr);
  }

  /// Returns an empty message for each one that Cyclone DDS refused.
  std::optional<std::span<const char>> Receive(double timeout_s) override {
    const dds_time_t end = dds_time() + static_cast<dds_duration_t>(std::min(timeout_s, 1e9) / kNanosecond);
    for (;;) {
      Free();
      void* sample = memory_.data();
      const dds_return_t count = dds_take(reader_.entity, &sample, &info_, 1, 1);
      if (count > 0 && info_.valid_data) return std::span<const char>(memory_);
      if (count > 0) continue;  // a sender has left
      if (refused_ != undecodable_) {
        ++refused_;
        return Refuse("a message has another size or layout");
      }
      dds_requested_incompatible_qos_status_t refused{};
      dds_get_requested_incompatible_qos_status(reader_.entity, &refused);
      if (refused.total_count_change > 0)
        return Refuse(refused.last_policy_id == DDS_TYPE_CONSISTENCY_ENFORCEMENT_QOS_POLICY_ID
                          ? "a sender offers another type under this name"
                          : "a sender offers the topic without lock_step");
      const dds_duration_t left = end - dds_time();
      if (left <= 0) return {};
      dds_waitset_wait(waiting_.entity, nullptr, 0, left);
    }
  }
  std::optional<std::span<const char>> Refuse(const char* reason) {
    refusal_ = reason;
    return std::span<const char>();
  }

  std::string Read(std::span<const char> message, double* timestamp, void* value) override {
    std::string reason = refusal_;
    if (!message.empty()) {
      *timestamp = kNanosecond * static_cast<double>(info_.source_timestamp);
      dds_time_t& last = last_.try_emplace(info_.publication_handle, INT64_MIN).first->second;
      const bool late = !end_.end.lock_step && info_.source_timestamp < last;
      reason =
          late ? "a message is older than the last one of its sender" : ReadMessage(message.data(), value);
      if (reason.empty()) last = info_.source_timestamp;
    }
    return reason.empty() ? reason : fmt::format("{}: {}", Description(), reason);
  }
  std::string Description() const override {
    return fmt::format("DDS topic '{}' of domain {}", end_.end.topic, end_.end.link.domain);
  }

  std::string ReadMessage(const void* message, void* value) {
    const TypeInfo* type = end_.message.as_is;
    if (type == nullptr) return end_.message.read(message, value);
    type->assign(candidate_->get(), value);  // has the lengths of the lists
    std::string reason = ReadC(*type, message, candidate_->get());
    if (reason.empty()) reason = NotFinite(*type, candidate_->get());
    if (reason.empty()) type->assign(value, candidate_->get());
    return reason;
  }
  /// Frees texts and lists that Cyclone DDS has allocated.
  void Free() {
    const auto* type = static_cast<const dds_topic_descriptor_t*>(end_.message.descriptor);
    if ((type->m_flagset & DDS_TOPIC_FIXED_SIZE) != 0) return;
    dds_sample_free(memory_.data(), type, DDS_FREE_CONTENTS);
    std::ranges::fill(memory_, 0);
  }

  const End end_;
  std::optional<AnyValue> candidate_;
  const std::atomic<int>& undecodable_;  ///< of all readers of this topic and type in the program
  int refused_ = undecodable_;
  const OwnedEntity reader_, ready_, waiting_;
  std::vector<char> memory_;
  dds_sample_info_t info_{};
  const char* refusal_ = "";
  std::map<dds_instance_handle_t, dds_time_t> last_;  ///< time of the last message of each sender
};

class DdsWriter final : public DdsSender {
 public:
  DdsWriter(const DdsEnd& end, const DdsMessage& message)
      : end_(end, message),
        writer_(dds_create_writer(end_.participant.get(), end_.topic.entity,
                                  QualityOfService(end, DepthOf(end, message)).get(), nullptr)) {}

  bool Send(double time, const void* value, std::vector<char>& memory) const override {
    if (end_.message.as_is != nullptr) {
      WriteC(*end_.message.as_is, value, memory);
    } else {
      memory.assign(end_.message.size, 0);
      end_.message.write(value, memory.data());
    }
    const dds_time_t stamp = end_.end.lock_step ? std::llround(time / kNanosecond) : dds_time();
    return dds_write_ts(writer_.entity, memory.data(), stamp) == DDS_RETCODE_OK;
  }

 private:
  static int DepthOf(const DdsEnd& end, const DdsMessage& message) {
    constexpr int kDepth = 1, kDepthInRos2 = 10;
    Demand(end.depth >= 0, fmt::format("depth = {} must be positive, or 0 for the default", end.depth));
    return end.depth > 0 ? end.depth : message.as_is != nullptr ? kDepthInRos2 : kDepth;
  }

  const End end_;
  const OwnedEntity writer_;
};

}  // namespace

std::string NotFinite(const TypeInfo& type, const void* value) {
  if (FinitenessOf(type, value) == Finiteness::kFinite) return "";
  const std::vector<Element> elements = ListElements(type, value, "value");
  const std::vector<double> numbers = DoublesOf(type, value);
  std::size_t i = 0;
  while (i + 1 < numbers.size() && std::isfinite(numbers[i])) ++i;
  return fmt::format("'{}' = {} is not finite", elements[i].name, numbers[i]);
}

std::unique_ptr<DdsSender> MakeDdsSender(const DdsEnd& end, const DdsMessage& message) {
  return std::make_unique<DdsWriter>(end, message);
}

std::unique_ptr<Inbox> MakeDdsInbox(const DdsEnd& end, const DdsMessage& message, double timeout_s) {
  return std::make_unique<DdsInbox>(end, message, timeout_s);
}

}  // namespace tenon::internal
