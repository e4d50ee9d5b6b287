#pragma once

#include <tenon/systems/framework/types/errors.h>

#include <cstddef>
#include <filesystem>
#include <string_view>

namespace tenon {

/// What is to be kept cannot be written: the disk is full, the place is not there or belongs to others.
class OutputError : public RunError {
 public:
  using RunError::RunError;
};

/// Writes a file as a whole: the text goes into a file beside it, `.NAME.PID.part`, which then takes its
/// name. So a reader, or who comes after a kill, finds what was there before or all of the new. What is no
/// regular file, "/dev/stdout", is written as it is. Throws OutputError, and leaves nothing behind.
void WriteFile(const std::filesystem::path& file, std::string_view text);

/// A file that grows by whole texts: what the disk does not take as a whole is taken back. Only a SIGKILL
/// within Append, which ends a write between two pages, leaves a part of one.
class GrowingFile {
 public:
  enum class Start { kEmpty, kKeep };
  /// An empty file, whatever was there; or what was there, if it is to be kept. Throws OutputError if it
  /// cannot be opened.
  explicit GrowingFile(std::filesystem::path path, Start start = Start::kEmpty);
  ~GrowingFile();
  GrowingFile(const GrowingFile&) = delete;
  GrowingFile& operator=(const GrowingFile&) = delete;

  /// Writes at its end. Throws OutputError with the cause; then the file is as it was before.
  void Append(std::string_view text);
  /// Takes back all behind the first `size` bytes. Throws OutputError if that is not possible: a pipe keeps
  /// what it has.
  void Truncate(std::size_t size);
  std::size_t size() const { return size_; }  ///< [bytes]
  /// Waits until all of it is on the disk, so that a power failure does not take it. Throws OutputError.
  void Sync() const;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
  int descriptor_;
  std::size_t size_ = 0;  ///< [bytes]
};

}  // namespace tenon
