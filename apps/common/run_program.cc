#include <tenon/apps/common/run_program.h>
#include <tenon/systems/files/output_file.h>

#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace tenon::apps {

std::optional<int> RunProgram(std::vector<std::string> arguments) {
  std::vector<char*> list;
  for (std::string& argument : arguments) list.push_back(argument.data());
  list.push_back(nullptr);
  ::pid_t process = 0;
  const int error = ::posix_spawnp(&process, list[0], nullptr, nullptr, list.data(), environ);
  if (error == ENOENT) return {};
  if (error != 0) throw OutputError(fmt::format("cannot run `{}`: {}", arguments[0], std::strerror(error)));
  int status = 0;
  while (::waitpid(process, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

}  // namespace tenon::apps
