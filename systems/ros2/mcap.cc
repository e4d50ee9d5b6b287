#include <tenon/systems/io/internal/no_signals.h>
#include <tenon/systems/ros2/internal/cdr.h>
#include <tenon/systems/ros2/mcap.h>
#include <tenon/systems/text/text.h>
#include <tenon/systems/version.h>

#include <boost/crc.hpp>
#include <fmt/core.h>

#include <fstream>

namespace tenon {

namespace internal {

void WriteMcapMessage(const TypeInfo& type, const void* message, std::vector<char>& out) {
  WriteCdr(type, message, out);
}

}  // namespace internal

namespace {

constexpr std::string_view kMagic = "\x89MCAP0\r\n";
constexpr std::size_t kChunkSize = 1 << 18;       // [bytes]
constexpr std::uint64_t kMostBytes = 1ULL << 30;  // of a record that is read

/// Kinds of records.
enum Op : std::uint8_t {
  kHeader = 1,
  kFooter,
  kSchema,
  kChannel,
  kMessage,
  kChunk,
  kMessageIndex,
  kChunkIndex,
  kStatistics = 0x0B,
  kSummaryOffset = 0x0E,
  kDataEnd
};

/// CRC-32 of ISO 3309.
std::uint32_t Crc32(std::span<const char> bytes) {
  boost::crc_32_type crc;
  crc.process_bytes(bytes.data(), bytes.size());
  return crc.checksum();
}

template <class T>
requires std::is_arithmetic_v<T>
void PutField(std::vector<char>& out, T number) {
  const auto* bytes = reinterpret_cast<const char*>(&number);
  out.insert(out.end(), bytes, bytes + sizeof(T));
}
void PutField(std::vector<char>& out, std::string_view text) {
  PutField(out, static_cast<std::uint32_t>(text.size()));
  out.insert(out.end(), text.begin(), text.end());
}
/// Appends the fields of a record: numbers, and texts behind their length.
void Put(std::vector<char>& out, const auto&... fields) {
  (PutField(out, fields), ...);
}

/// Bytes of a record, read from the front. It is not `good` behind its end.
class Fields {
 public:
  explicit Fields(std::span<const char> bytes) : bytes_(bytes) {}
  template <class T>
  T Number() {
    T number{};
    const std::span<const char> from = Bytes(sizeof(T));
    if (good_) std::memcpy(&number, from.data(), sizeof(T));
    return number;
  }
  std::string_view Text() {
    const std::span<const char> text = Bytes(Number<std::uint32_t>());
    return {text.data(), text.size()};
  }
  std::span<const char> Bytes(std::uint64_t size) {
    good_ = good_ && size <= bytes_.size();
    const std::span<const char> part = good_ ? bytes_.first(size) : std::span<const char>();
    bytes_ = good_ ? bytes_.subspan(size) : std::span<const char>();
    return part;
  }
  std::span<const char> rest() const { return bytes_; }
  bool good() const { return good_; }

 private:
  std::span<const char> bytes_;
  bool good_ = true;
};

/// Appends the length in bytes of what `write` appends, and that: a list or a map.
template <class Length = std::uint32_t>
void PutList(std::vector<char>& out, const auto& write) {
  const std::size_t length_at = out.size();
  Put(out, Length{0});
  write();
  const auto length = static_cast<Length>(out.size() - length_at - sizeof(Length));
  std::memcpy(out.data() + length_at, &length, sizeof length);
}
void PutRecord(std::vector<char>& out, Op op, const auto& write) {
  out.push_back(static_cast<char>(op));
  PutList<std::uint64_t>(out, write);
}

}  // namespace

McapFile::McapFile(const std::filesystem::path& path) : file_(path) {
  std::vector<char> start(kMagic.begin(), kMagic.end());
  PutRecord(start, kHeader, [&] { Put(start, "ros2", std::string("tenon ") + Version()); });
  Append(start);
  for (std::vector<char>* bytes : {&filled_, &chunk_}) bytes->reserve(kChunkSize + kChunkSize / 4);
  const internal::NoSignals no_signals;
  thread_ = std::thread([this] {
    for (bool last = false; !last; free_.release()) {
      work_.acquire();
      last = closed_;
      try {
        if (error_ == nullptr) WriteChunk();
      } catch (const OutputError&) {
        error_ = std::current_exception();
      }
      chunk_.clear();
    }
  });
}

McapFile::~McapFile() {
  try {
    Close();
  } catch (const OutputError&) {
  }
}

void McapFile::Append(const std::vector<char>& bytes) {
  file_.Append({bytes.data(), bytes.size()});
  boost::crc_32_type crc(crc_);
  crc.process_bytes(bytes.data(), bytes.size());
  crc_ = crc.get_interim_remainder();
}

std::uint16_t McapFile::AddTopic(const std::string& topic, const internal::TypeInfo& type) {
  const std::lock_guard lock(mutex_);
  const std::string name = ros2::NameOf(type);
  const bool is_new = !schemas_.contains(name);
  const auto schema =
      schemas_.try_emplace(name, static_cast<std::uint16_t>(schemas_.size() + 1)).first->second;
  if (is_new)
    PutRecord(declared_, kSchema,
              [&] { Put(declared_, schema, name, "ros2msg", internal::Ros2Definition(type)); });
  const auto number = static_cast<std::uint16_t>(counts_.size());
  counts_.push_back(0);
  PutRecord(declared_, kChannel, [&] {
    Put(declared_, number, schema, topic, "cdr");
    PutList(declared_, [] {});
  });
  return number;
}

void McapFile::Write(std::uint16_t topic, double time, std::span<const char> cdr) {
  const std::lock_guard lock(mutex_);
  if (closed_) return;
  const auto stamp = static_cast<std::uint64_t>(std::llround(std::max(time, 0.0) * 1e9));
  if (written_ < declared_.size()) {  // the first chunk that needs them has the schemas and channels
    filled_.insert(filled_.end(), declared_.begin() + static_cast<std::ptrdiff_t>(written_), declared_.end());
    written_ = declared_.size();
  }
  PutRecord(filled_, kMessage, [&] {
    Put(filled_, topic, counts_.at(topic)++, stamp, stamp);
    filled_.insert(filled_.end(), cdr.begin(), cdr.end());
  });
  if (filled_.size() >= kChunkSize) HandOver(false);
}

/// Lets the thread write the records so far, when it has written those before.
void McapFile::HandOver(bool last) {
  free_.acquire();
  closed_ = last;
  std::swap(filled_, chunk_);
  work_.release();
}

void McapFile::WriteChunk() {
  if (chunk_.empty()) return;
  Chunk made{UINT64_MAX, 0, file_.size(), 0, 0, chunk_.size(), {}};
  std::map<std::uint16_t, std::vector<std::pair<std::uint64_t, std::uint64_t>>> index;  // times and places
  for (Fields records(chunk_); !records.rest().empty();) {
    const std::size_t place = chunk_.size() - records.rest().size();
    const auto op = records.Number<std::uint8_t>();
    Fields message(records.Bytes(records.Number<std::uint64_t>()));
    if (op != kMessage) continue;
    const auto topic = message.Number<std::uint16_t>();
    message.Number<std::uint32_t>();
    const auto time = message.Number<std::uint64_t>();
    index[topic].emplace_back(time, place);
    made.begin = std::min(made.begin, time);
    made.end = std::max(made.end, time);
  }
  record_.clear();
  PutRecord(record_, kChunk, [&] {
    const std::uint64_t size = chunk_.size();
    Put(record_, made.begin, made.end, size, Crc32(chunk_), "", size);
    record_.insert(record_.end(), chunk_.begin(), chunk_.end());
  });
  made.length = record_.size();
  for (const auto& [topic, messages] : index) {
    made.indices.emplace_back(topic, made.start + record_.size());
    PutRecord(record_, kMessageIndex, [&, topic = topic, &messages = messages] {
      Put(record_, topic);
      PutList(record_, [&] {
        for (const auto& [time, at] : messages) Put(record_, time, at);
      });
    });
  }
  made.index_length = record_.size() - made.length;
  Append(record_);
  chunks_.push_back(std::move(made));
}

void McapFile::Close() {
  const std::lock_guard lock(mutex_);
  if (closed_) return;
  HandOver(true);
  thread_.join();
  if (error_ != nullptr) std::rethrow_exception(error_);
  std::vector<char> end;
  PutRecord(end, kDataEnd, [&] { Put(end, std::uint32_t{boost::crc_32_type(crc_).checksum()}); });
  Append(end);

  const std::uint64_t start = file_.size();
  std::vector<char> summary = declared_;
  std::vector<std::array<std::uint64_t, 3>> groups;  // kind, begin, length
  const auto group = [&](Op op, const auto& write) {
    const std::size_t begin = summary.size();
    write();
    if (summary.size() > begin) groups.push_back({op, start + begin, summary.size() - begin});
  };
  group(kStatistics, [&] {
    PutRecord(summary, kStatistics, [&] {
      std::uint64_t count = 0, first = UINT64_MAX, last = 0;
      for (const std::uint32_t each : counts_) count += each;
      for (const Chunk& chunk : chunks_)
        first = std::min(first, chunk.begin), last = std::max(last, chunk.end);
      constexpr std::uint32_t kNone = 0;  // attachments and metadata
      Put(summary, count, static_cast<std::uint16_t>(schemas_.size()),
          static_cast<std::uint32_t>(counts_.size()), kNone, kNone,
          static_cast<std::uint32_t>(chunks_.size()), chunks_.empty() ? 0 : first, last);
      PutList(summary, [&] {
        for (std::size_t i = 0; i < counts_.size(); ++i)
          Put(summary, static_cast<std::uint16_t>(i), std::uint64_t{counts_[i]});
      });
    });
  });
  group(kChunkIndex, [&] {
    for (const Chunk& chunk : chunks_)
      PutRecord(summary, kChunkIndex, [&] {
        Put(summary, chunk.begin, chunk.end, chunk.start, chunk.length);
        PutList(summary, [&] {
          for (const auto& [topic, place] : chunk.indices) Put(summary, topic, place);
        });
        Put(summary, chunk.index_length, "", chunk.size, chunk.size);
      });
  });
  const std::uint64_t offsets = start + summary.size();
  for (const auto& place : groups)
    PutRecord(summary, kSummaryOffset,
              [&] { Put(summary, static_cast<std::uint8_t>(place[0]), place[1], place[2]); });
  PutRecord(summary, kFooter, [&] {
    Put(summary, start, offsets);
    std::uint64_t length = sizeof(start) + sizeof(offsets) + sizeof(std::uint32_t);
    std::memcpy(summary.data() + summary.size() - sizeof(start) - sizeof(offsets) - sizeof(length), &length,
                sizeof length);  // the checksum covers it
    Put(summary, Crc32(summary));
  });
  summary.insert(summary.end(), kMagic.begin(), kMagic.end());
  Append(summary);
}

void McapPublisherParams::Validate() const {
  Demand(file != nullptr, "`file` is missing: give the McapFile that is written");
  Demand(!topic.empty(), "`topic` is empty: set the name of the topic, such as \"/joint_states\"");
}

std::string McapMessage::Read(const internal::TypeInfo& type_info, void* message) const {
  const std::string wanted = ros2::NameOf(type_info);
  if (type != wanted)
    return fmt::format("the topic '{}' has the type {} and not {}", internal::Excerpt(topic),
                       internal::Excerpt(type), wanted);
  if (encoding != "cdr")
    return fmt::format("the topic '{}' is encoded as '{}' and not as cdr", internal::Excerpt(topic),
                       internal::Excerpt(encoding));
  std::string reason = internal::ReadCdr(type_info, data, message);
  if (!reason.empty())
    reason = fmt::format("topic '{}', t = {} s: {}", internal::Excerpt(topic), time, reason);
  return reason;
}

namespace {

class McapReader {
 public:
  McapReader(const std::filesystem::path& path, const std::function<void(const McapMessage&)>& visit)
      : path_(internal::Excerpt(path.string())), visit_(visit) {
    file_.open(path, std::ios::binary);
    std::error_code error;
    size_ = std::filesystem::is_regular_file(path, error) ? std::filesystem::file_size(path, error) : 0;
    if (!file_ || error || size_ == 0)
      throw ParameterError(fmt::format("'{}' cannot be read, or is empty: give an MCAP file", path_));
    std::string magic(kMagic.size(), '\0');
    file_.read(magic.data(), static_cast<std::streamsize>(magic.size()));
    if (magic != kMagic)
      throw ParameterError(fmt::format("'{}' is no MCAP file: its first bytes differ", path_));
    at_ = kMagic.size();
  }

  std::string Read() {
    std::vector<char> content;
    for (;;) {
      constexpr std::uint64_t kHead = 1 + sizeof(std::uint64_t);
      if (size_ - at_ < kHead) return Told("ends without a summary");
      std::array<char, kHead> head{};
      file_.read(head.data(), kHead);
      std::uint64_t length = 0;
      std::memcpy(&length, head.data() + 1, sizeof length);
      const auto op = static_cast<Op>(head[0]);
      if (op == kDataEnd || op == kFooter) return "";
      if (length > size_ - at_ - kHead) {
        if (op != kChunk || size_ - at_ > kMostBytes) return Told("ends within a record");
        content.resize(size_ - at_ - kHead);
        file_.read(content.data(), static_cast<std::streamsize>(content.size()));
        Fields fields(content);
        ChunkOf(fields, true);
        return Told("ends within a chunk, of which the whole messages were read");
      }
      if (op == kHeader || op == kSchema || op == kChannel || op == kMessage || op == kChunk) {
        if (length > kMostBytes) return Told(fmt::format("has a record of {} bytes", length));
        content.resize(length);
        file_.read(content.data(), static_cast<std::streamsize>(length));
        if (!file_) return Told("cannot be read further");
        const std::string wrong = Record(op, content, true);
        if (!wrong.empty()) return Told(wrong);
      } else {
        file_.seekg(static_cast<std::streamoff>(length), std::ios::cur);
      }
      at_ += kHead + length;
    }
  }

 private:
  struct Channel {
    std::string topic, encoding, type;
  };

  std::string Told(const std::string& what) const {
    return fmt::format("'{}' {}: read up to byte {} of {}", path_, what, at_, size_);
  }

  /// Returns what is wrong with a record, or an empty text.
  std::string Record(Op op, std::span<const char> content, bool outside_chunk) {
    Fields fields(content);
    if (op == kSchema) {
      const auto id = fields.Number<std::uint16_t>();
      schemas_[id] = fields.Text();
    } else if (op == kChannel) {
      const auto id = fields.Number<std::uint16_t>(), schema = fields.Number<std::uint16_t>();
      const std::string_view topic = fields.Text(), encoding = fields.Text();
      channels_[id] = {std::string(topic), std::string(encoding), schemas_[schema]};
    } else if (op == kMessage) {
      const auto channel = channels_.find(fields.Number<std::uint16_t>());
      fields.Number<std::uint32_t>();
      const auto time = fields.Number<std::uint64_t>();
      fields.Number<std::uint64_t>();
      if (channel == channels_.end()) return "has a message of an unknown channel";
      if (fields.good())
        visit_({.topic = channel->second.topic,
                .type = channel->second.type,
                .encoding = channel->second.encoding,
                .time = static_cast<double>(time) * 1e-9,
                .data = fields.rest()});
    } else if (op == kChunk && outside_chunk) {
      return ChunkOf(fields, false);
    }
    return fields.good() ? "" : "has a damaged record";
  }

  /// A chunk that is `cut` ends early, and its checksum is unknown.
  std::string ChunkOf(Fields& fields, bool cut) {
    fields.Bytes(2 * sizeof(std::uint64_t));
    const auto size = fields.Number<std::uint64_t>();
    const auto crc = fields.Number<std::uint32_t>();
    const std::string_view compression = fields.Text();
    if (fields.good() && !compression.empty())
      throw ParameterError(
          fmt::format("'{}' is compressed by '{}', which is not supported: decompress it by `mcap compress "
                      "--compression none`",
                      path_, internal::Excerpt(compression)));
    const auto length = fields.Number<std::uint64_t>();
    const std::span<const char> records = cut ? fields.rest() : fields.Bytes(length);
    if (!fields.good() || (!cut && records.size() != size)) return "has a damaged chunk";
    if (!cut && crc != 0 && crc != Crc32(records)) return "has a chunk with a wrong checksum";
    Fields inside(records);
    while (!inside.rest().empty()) {
      const auto op = static_cast<Op>(inside.Number<std::uint8_t>());
      const std::span<const char> content = inside.Bytes(inside.Number<std::uint64_t>());
      if (!inside.good()) return "has a damaged chunk";
      if (std::string wrong = Record(op, content, false); !wrong.empty()) return wrong;
    }
    return "";
  }

  std::string path_;
  const std::function<void(const McapMessage&)>& visit_;
  std::ifstream file_;
  std::uint64_t size_ = 0, at_ = 0;  ///< of the file, and of the part that was read [bytes]
  std::map<std::uint16_t, std::string> schemas_;
  std::map<std::uint16_t, Channel> channels_;
};

}  // namespace

std::string ReadMcap(const std::filesystem::path& path,
                     const std::function<void(const McapMessage&)>& visit) {
  return McapReader(path, visit).Read();
}

}  // namespace tenon
