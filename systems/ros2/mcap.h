#pragma once

#include <tenon/systems/block.h>
#include <tenon/systems/files/output_file.h>
#include <tenon/systems/ros2/messages.h>

#include <exception>
#include <mutex>
#include <semaphore>
#include <thread>

namespace tenon {

namespace internal {

/// Writes a message in CDR to `out`, see internal/cdr.h.
void WriteMcapMessage(const TypeInfo& type, const void* message, std::vector<char>& out);

}  // namespace internal

/// A recording of messages of ROS 2 in an MCAP file (profile ros2, encodings cdr and ros2msg), which
/// PlotJuggler, Foxglove and `ros2 bag` open. Messages are stored in chunks without compression, with index,
/// summary and checksums. When a chunk has 256 kB, a thread writes it while the next one is
/// filled; Write waits only if the next one is full before. A run that is killed leaves its whole chunks,
/// which readers find without the summary.
class McapFile {
 public:
  /// Throws OutputError if the file cannot be opened.
  explicit McapFile(const std::filesystem::path& path);
  /// Closes the file; an error is then not reported.
  ~McapFile();
  McapFile(const McapFile&) = delete;
  McapFile& operator=(const McapFile&) = delete;

  /// Adds a topic such as "/joint_states". Returns its number.
  std::uint16_t AddTopic(const std::string& topic, const internal::TypeInfo& type);
  /// Adds a message in CDR at a time of the run [s]. If the disk is full, the file keeps its whole chunks,
  /// and this and further messages are lost.
  void Write(std::uint16_t topic, double time, std::span<const char> cdr);
  /// Writes the last chunk and the summary. Throws OutputError, also for the first error of Write.
  void Close();

 private:
  struct Chunk {
    std::uint64_t begin, end, start, length, index_length, size;
    std::vector<std::pair<std::uint16_t, std::uint64_t>> indices;
  };
  void Append(const std::vector<char>& bytes);
  void WriteChunk();
  void HandOver(bool last);

  std::mutex mutex_;
  GrowingFile file_;
  std::uint32_t crc_ = UINT32_MAX;    ///< remainder of the file so far, see mcap.cc
  std::vector<char> declared_;        ///< records of schemas and channels
  std::vector<char> filled_, chunk_;  ///< records in memory, and those that the thread writes
  std::vector<char> record_;
  std::size_t written_ = 0;  ///< length of `declared_` that is in the file
  std::map<std::string, std::uint16_t> schemas_;
  std::vector<std::uint32_t> counts_;  ///< of messages by topic
  std::vector<Chunk> chunks_;
  std::exception_ptr error_;  ///< the first error
  bool closed_ = false;

  std::binary_semaphore work_{0}, free_{1};  ///< wakes the thread, and says that it has written its chunk
  std::thread thread_;
};

struct McapPublisherParams {
  std::shared_ptr<McapFile> file = {};
  std::string topic = "";  ///< such as "/joint_states"
  Rate rate = Hz(100);

  void Validate() const;  ///< throws ParameterError without a file or a topic
};

/// Writes the messages at its input into an MCAP file.
///
///     const auto file = std::make_shared<McapFile>("run.mcap");
///     auto& log = builder.Add<McapPublisher<ros2::sensor_msgs::Imu>>("log", {.file = file, .topic =
///     "/imu"});
///
/// The time of a message is that of the run. Messages of a run that was set back stay in the file.
template <ros2::Message M>
class McapPublisher final : public LeafSystem<McapPublisherParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPort<M> u{this, "u"};
  Workspace<std::vector<char>> cdr{this, "cdr"};
  Publish write{this, "write", Sampled{params.rate}, Uses(time, u, cdr), &McapPublisher::Write};

 private:
  void Write(double t, const M& message, std::vector<char>& bytes) const {
    internal::WriteMcapMessage(internal::TypeInfoOf<M>(), &message, bytes);
    params.file->Write(topic_, t, bytes);
  }
  std::uint16_t topic_ = params.file->AddTopic(params.topic, internal::TypeInfoOf<M>());
};

/// A message in an MCAP file. The views are valid during the call that receives it.
struct McapMessage {
  std::string_view topic;     ///< such as "/imu"
  std::string_view type;      ///< name of its schema, such as "sensor_msgs/msg/Imu"
  std::string_view encoding;  ///< "cdr" in ROS 2
  double time = 0;            ///< when it was recorded [s]
  std::span<const char> data = {};

  /// Reads the message. Returns an empty text, or the reason why it is refused: another type or encoding,
  /// or bytes that are not those of the type.
  template <ros2::Message M>
  std::string Read(M& message) const {
    return Read(internal::TypeInfoOf<M>(), &message);
  }
  std::string Read(const internal::TypeInfo& type_info, void* message) const;
};

/// Reads an MCAP file from its beginning, without its index, and calls `visit` with each message in the order
/// of the file. Chunks may be compressed by none. Returns an empty text, or what is wrong and up to which
/// byte the file was read: it is truncated or damaged. Throws ParameterError if the file cannot be read, is
/// no MCAP file, or is compressed.
std::string ReadMcap(const std::filesystem::path& path, const std::function<void(const McapMessage&)>& visit);

}  // namespace tenon
