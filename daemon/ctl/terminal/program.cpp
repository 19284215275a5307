#include "daemon/ctl/terminal/program.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <system_error>

#include "hw/file_descriptor.hpp"

namespace contourd::ctl {
namespace {

std::vector<char*> arguments(const std::vector<std::string>& words) {
  std::vector<char*> pointers;
  for (const std::string& word : words)
    pointers.push_back(const_cast<char*>(word.c_str()));  // execve(2) does not modify them
  pointers.push_back(nullptr);
  return pointers;
}

std::system_error cannot_start(const std::string& name, int error) {
  return {error, std::generic_category(), "cannot start " + name};
}

// Starts the program with its standard output at `out` and its standard error at /dev/null.
pid_t start(const std::vector<std::string>& words, int out) {
  posix_spawn_file_actions_t actions{};
  (void)::posix_spawn_file_actions_init(&actions);
  (void)::posix_spawn_file_actions_adddup2(&actions, out, STDOUT_FILENO);
  (void)::posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  pid_t process = 0;
  const int error =
      ::posix_spawnp(&process, words.front().c_str(), &actions, nullptr, arguments(words).data(), environ);
  (void)::posix_spawn_file_actions_destroy(&actions);
  if (error != 0) throw cannot_start(words.front(), error);
  return process;
}

std::string read_some(int from, std::size_t most) {
  std::string text;
  std::array<char, 65536> buffer;
  while (text.size() < most) {
    const ssize_t bytes = ::read(from, buffer.data(), std::min(buffer.size(), most - text.size()));
    if (bytes < 0 && errno == EINTR) continue;
    if (bytes <= 0) break;
    text.append(buffer.data(), static_cast<std::size_t>(bytes));
  }
  return text;
}

}  // namespace

ProgramOutput run_program(const std::vector<std::string>& words, std::size_t most_bytes) {
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) throw cannot_start(words.front(), errno);
  FileDescriptor out(ends[0]), in(ends[1]);
  const pid_t process = start(words, in.get());
  in = FileDescriptor();
  ProgramOutput output{.text = read_some(out.get(), most_bytes)};
  out = FileDescriptor();  // ends a program that still writes, by SIGPIPE
  int status = 0;
  while (::waitpid(process, &status, 0) < 0 && errno == EINTR) {
  }
  output.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return output;
}

void become_program(const std::vector<std::string>& words) {
  (void)::execvp(words.front().c_str(), arguments(words).data());
  throw cannot_start(words.front(), errno);
}

}  // namespace contourd::ctl
