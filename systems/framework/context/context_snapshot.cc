#include <tenon/systems/files/input_file.h>
#include <tenon/systems/files/output_file.h>
#include <tenon/systems/framework/context/context.h>
#include <tenon/systems/framework/diagram/diagram.h>
#include <tenon/systems/framework/diagram/internal/program.h>

#include <fmt/core.h>

namespace tenon {

using internal::Cell;

namespace {

/// The beginning of a snapshot. The checksum covers all bytes that follow, so that every change is detected.
struct Header {
  std::array<char, 8> magic = {'t', 'e', 'n', 'o', 'n', 's', 'n', 'p'};
  std::uint64_t version = 5;
  std::uint64_t size = 0;  ///< size of the payload [bytes]
  std::uint64_t checksum = 0;
};
static_assert(std::is_trivially_copyable_v<Header> && sizeof(Header) == 32, "it has no padding");

std::uint64_t ChecksumOf(std::span<const std::byte> bytes) {
  internal::Fnv1a checksum;
  checksum.Add({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  return checksum.value();
}

/// The bytes that follow the header. Throws RunError if they are truncated or damaged.
std::span<const std::byte> CheckedPayload(std::span<const std::byte> snapshot) {
  const Header mine;
  Header header;
  const std::size_t known = std::min(snapshot.size(), sizeof(Header));
  if (known > 0) std::memcpy(&header, snapshot.data(), known);
  if (header.magic != mine.magic)
    throw RunError("this is not a snapshot: give the bytes that Context::Save wrote");
  if (header.version != mine.version)
    throw RunError(
        fmt::format("the snapshot has format {}, but this program reads {}: save it again with this program",
                    header.version, mine.version));
  const std::span<const std::byte> payload = snapshot.subspan(known);
  if (known < sizeof(Header) || payload.size() < header.size)
    throw RunError(fmt::format("the snapshot is truncated after {} bytes", snapshot.size()));
  if (payload.size() > header.size)
    throw RunError(
        fmt::format("the snapshot is damaged: {} bytes follow its end", payload.size() - header.size));
  if (ChecksumOf(payload) != header.checksum)
    throw RunError("the snapshot is damaged: its checksum is wrong; use another copy of it");
  return payload;
}

}  // namespace

std::vector<std::byte> Context::Save() const {
  const internal::Program& program = diagram_->program();
  if (!failure_.empty()) {
    throw RunError(fmt::format("a failed run cannot be saved: {}. Save it before the failure", failure_));
  }
  internal::Archive archive;
  archive.bytes().resize(sizeof(Header));
  internal::Save(program.signature, archive);
  internal::Save(time(), archive);
  internal::Save(seed_, archive);
  internal::Save(progress_, archive);
  internal::Save(time_rest_, archive);
  internal::Save(begin_time_, archive);
  internal::Save(next_step_, archive);
  internal::Save(last_error_, archive);
  internal::Save(internal::TypeInfoOf<std::vector<double>>(), &witness_memory_, archive);
  internal::Save(internal::TypeInfoOf<std::vector<double>>(), &event_memory_, archive);
  internal::Save(num_steps_, archive);
  internal::Save(movement_, archive);
  internal::Save(step_start_.valid, archive);
  if (step_start_.valid) internal::Save(internal::TypeInfoOf<StepStart>(), &step_start_, archive);
  for (const Cell& cell : program.saved) {
    const Source& source = *cell.source;
    const bool fresh = source.calculation_ < 0 || IsFresh(program.calculations[source.calculation_].op);
    internal::Save(fresh, archive);
    try {
      const bool whole = source.kind() == SourceKind::kScratch || source.kind() == SourceKind::kDiscrete;
      internal::Save(*source.type_, memory_.get() + cell.offset, archive, whole);
    } catch (const Error& error) {
      throw RunError(fmt::format("'{}' cannot be saved: {}", source.path(), error.what()));
    }
  }
  for (const bool fixed : fixed_) internal::Save(fixed, archive);
  Header header;
  const std::span<const std::byte> payload = std::span(archive.bytes()).subspan(sizeof(Header));
  header.size = payload.size();
  header.checksum = ChecksumOf(payload);
  std::memcpy(archive.bytes().data(), &header, sizeof(Header));
  return std::move(archive.bytes());
}

void Context::Restore(std::span<const std::byte> bytes) {
  Clone()->Load(bytes);  // if the snapshot is rejected, this context stays unchanged
  Load(bytes);
}

void Context::Load(std::span<const std::byte> bytes) {
  const internal::Program& program = diagram_->program();
  internal::Archive archive;
  const std::span<const std::byte> payload = CheckedPayload(bytes);
  archive.Write(payload.data(), payload.size());
  std::uint64_t signature = 0;
  internal::Load(signature, archive);
  if (signature != program.signature) {
    throw RunError("the snapshot is of another diagram: restore it into the one that it was saved from");
  }
  double time = 0;
  internal::Load(time, archive);
  internal::Load(seed_, archive);
  internal::Load(progress_, archive);
  double time_rest = 0, begin_time = 0;
  internal::Load(time_rest, archive);
  internal::Load(begin_time, archive);
  if (!std::isfinite(time) || progress_ > Progress::kTickDue)
    throw RunError("the snapshot is damaged: its time or its progress is invalid");
  SetTime(time);
  time_rest_ = time_rest;
  begin_time_ = begin_time;
  failure_.clear();
  internal::Load(next_step_, archive);
  internal::Load(last_error_, archive);
  internal::Load(internal::TypeInfoOf<std::vector<double>>(), &witness_memory_, archive);
  internal::Load(internal::TypeInfoOf<std::vector<double>>(), &event_memory_, archive);
  internal::Load(num_steps_, archive);
  internal::Load(movement_, archive);
  internal::Load(step_start_.valid, archive);
  if (step_start_.valid) {
    internal::Load(internal::TypeInfoOf<StepStart>(), &step_start_, archive);
    if (step_start_.states.size() != static_cast<std::size_t>(program.num_continuous)) {
      throw RunError("the snapshot is damaged: the number of its states differs from the diagram's");
    }
  }
  for (const Cell& cell : program.saved) {
    bool fresh = false;
    internal::Load(fresh, archive);
    try {
      internal::Load(*cell.source->type_, memory_.get() + cell.offset, archive);
    } catch (const std::exception& error) {
      throw RunError(fmt::format("'{}' cannot be restored: {}", cell.source->path(), error.what()));
    }
    const int calculation = cell.source->calculation_;
    if (calculation < 0) continue;
    const std::uint64_t stamp = program.calculations[calculation].varies ? instant_ : 1;
    stamps_[calculation] = fresh ? stamp : 0;
  }
  for (std::size_t i = 0; i < fixed_.size(); ++i) {
    bool fixed = false;
    internal::Load(fixed, archive);
    fixed_[i] = fixed;
  }
  PackStates();
  if (!archive.exhausted()) throw RunError("the snapshot is damaged: it is longer than this diagram's");
}

void Context::SaveFile(const std::string& file) const {
  const std::vector<std::byte> bytes = Save();
  WriteFile(file, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

void Context::RestoreFile(const std::string& file) {
  std::ifstream in = OpenInput(file, std::ios::binary | std::ios::ate);
  if (!in.is_open()) throw RunError(fmt::format("cannot read the snapshot '{}'", file));
  std::vector<std::byte> bytes(static_cast<std::size_t>(in.tellg()));
  in.seekg(0);
  in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  try {
    Restore(bytes);
  } catch (const Error& error) {
    throw RunError(fmt::format("cannot restore '{}': {}", file, error.what()));
  }
}

}  // namespace tenon
