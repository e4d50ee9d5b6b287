#include <tenon/systems/files/output_file.h>

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

namespace tenon {

namespace fs = std::filesystem;

namespace {

[[noreturn]] void Fail(const fs::path& file, int error) {
  throw OutputError(fmt::format("cannot write '{}': {}; free disk space, or choose another path",
                                file.string(), std::strerror(error)));
}

/// Keeps other descriptors from locking a regular file, as long as this one is open.
void Lock(int descriptor, const fs::path& file) {
  struct ::stat status {};
  if (::fstat(descriptor, &status) != 0 || !S_ISREG(status.st_mode)) return;
  if (::flock(descriptor, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK)
    return;  // some disks have no locks
  ::close(descriptor);
  throw OutputError(
      fmt::format("cannot write '{}', because another log or program writes it: choose another "
                  "path",
                  file.string()));
}

/// Opens or creates a file, emptied unless `how` is 0. Errors name `wanted`.
int Open(const fs::path& file, const fs::path& wanted, int how = O_TRUNC) {
  const int descriptor = ::open(file.c_str(), O_WRONLY | O_CREAT | how | O_CLOEXEC, 0666);
  if (descriptor < 0) Fail(wanted, errno);
  return descriptor;
}

/// Returns 0, or the errno of a failed write.
int WriteAll(int descriptor, std::string_view text) {
  while (!text.empty()) {
    const ::ssize_t written = ::write(descriptor, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return errno;
    text.remove_prefix(static_cast<std::size_t>(written));
  }
  return 0;
}

}  // namespace

void WriteFile(const fs::path& file, std::string_view text) {
  std::error_code ignored;
  const fs::file_status status = fs::status(file, ignored);
  const bool in_place = fs::exists(status) && !fs::is_regular_file(status);
  fs::path part = file;
  if (!in_place) part.replace_filename(fmt::format(".{}.{}.part", file.filename().string(), ::getpid()));
  const int descriptor = Open(part, file);
  int error = WriteAll(descriptor, text);
  if (::close(descriptor) != 0 && error == 0) error = errno;
  if (!in_place && error == 0 && std::rename(part.c_str(), file.c_str()) != 0) error = errno;
  if (error == 0) return;
  if (!in_place) ::unlink(part.c_str());
  Fail(file, error);
}

GrowingFile::GrowingFile(fs::path path, Start start)
    : path_(std::move(path)), descriptor_(Open(path_, path_, 0)) {
  Lock(descriptor_, path_);
  if (start == Start::kEmpty) static_cast<void>(::ftruncate(descriptor_, 0));  // fails for a pipe
  if (const ::off_t end = ::lseek(descriptor_, 0, SEEK_END); end > 0) size_ = static_cast<std::size_t>(end);
}

GrowingFile::~GrowingFile() {
  ::close(descriptor_);
}

void GrowingFile::Append(std::string_view text) {
  if (const int error = WriteAll(descriptor_, text); error != 0) {
    const bool taken_back =
        ::ftruncate(descriptor_, static_cast<::off_t>(size_)) == 0 && ::lseek(descriptor_, 0, SEEK_END) >= 0;
    static_cast<void>(taken_back);  // fails unless the file is regular
    Fail(path_, error);
  }
  size_ += text.size();
}

void GrowingFile::Truncate(std::size_t size) {
  const auto end = static_cast<::off_t>(size);
  if (::ftruncate(descriptor_, end) != 0 || ::lseek(descriptor_, end, SEEK_SET) < 0) Fail(path_, errno);
  size_ = size;
}

void GrowingFile::Sync() const {
  const bool failed = ::fsync(descriptor_) != 0;
  if (failed && errno != EINVAL && errno != EROFS) Fail(path_, errno);  // these mean: not a file on a disk
}

}  // namespace tenon
