#pragma once

#include <tenon/systems/framework/types/errors.h>

#include <cstddef>
#include <filesystem>
#include <string_view>

namespace tenon {

/// A file cannot be written, because the disk is full, the path does not exist or permission is missing.
class OutputError : public RunError {
 public:
  using RunError::RunError;
};

/// Writes a file atomically: writes the text to `.NAME.PID.part` beside it and renames that file. Even if the
/// process is killed, the file holds either its old or its new contents. Files that are not regular, such as
/// "/dev/stdout", are written directly. Throws OutputError and then removes the temporary file.
void WriteFile(const std::filesystem::path& file, std::string_view text);

/// A file that grows by whole texts: if the disk does not take a whole text, its beginning is removed again.
/// Only a SIGKILL during Append can leave a partial text.
class GrowingFile {
 public:
  enum class Start { kEmpty, kKeep };
  /// Opens the file and keeps or discards its contents. Throws OutputError if it cannot be opened, or another
  /// GrowingFile of any process is open on it.
  explicit GrowingFile(std::filesystem::path path, Start start = Start::kEmpty);
  ~GrowingFile();
  GrowingFile(const GrowingFile&) = delete;
  GrowingFile& operator=(const GrowingFile&) = delete;

  /// Writes at the end. On failure, throws OutputError and leaves the file unchanged.
  void Append(std::string_view text);
  /// Keeps only the first `size` bytes. Throws OutputError if that is not possible, as for a pipe.
  void Truncate(std::size_t size);
  std::size_t size() const { return size_; }  ///< [bytes]
  /// Waits until the file is on the disk and safe from a power failure. Throws OutputError.
  void Sync() const;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
  int descriptor_;
  std::size_t size_ = 0;  ///< [bytes]
};

}  // namespace tenon
