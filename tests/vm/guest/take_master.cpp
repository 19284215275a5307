// Takes a display's card from the program that has it, like a display server that becomes active:
//   take-master PROCESS CARD
// Prints "taken" when it has the card. The card is released when this program is killed.
#include <dirent.h>
#include <drm.h>
#include <fcntl.h>
#include <sys/ioctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <string>

namespace {

[[noreturn]] void fail(const char* what) {
  std::perror(what);
  std::exit(1);
}

// Returns the file descriptor under which the process has the card open.
int descriptor_of(const std::string& process, const std::string& card) {
  const std::string folder = "/proc/" + process + "/fd/";
  DIR* const descriptors = ::opendir(folder.c_str());
  if (descriptors == nullptr) fail(folder.c_str());
  while (const dirent* entry = ::readdir(descriptors)) {
    char target[256];
    const ssize_t length = ::readlink((folder + entry->d_name).c_str(), target, sizeof target);
    if (length > 0 && std::string(target, static_cast<std::size_t>(length)) == card)
      return std::atoi(entry->d_name);
  }
  std::fprintf(stderr, "process %s does not have %s open\n", process.c_str(), card.c_str());
  std::exit(1);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fputs("usage: take-master PROCESS CARD\n", stderr);
    return 64;
  }
  const std::string process = argv[1], card = argv[2];
  const auto pidfd = static_cast<int>(::syscall(SYS_pidfd_open, std::atoi(process.c_str()), 0));
  if (pidfd < 0) fail("pidfd_open");
  const auto theirs = static_cast<int>(::syscall(SYS_pidfd_getfd, pidfd, descriptor_of(process, card), 0));
  if (theirs < 0) fail("pidfd_getfd");
  if (::ioctl(theirs, DRM_IOCTL_DROP_MASTER, 0) != 0) fail("drop master");
  ::close(theirs);
  const int own = ::open(card.c_str(), O_RDWR);
  if (own < 0 || ::ioctl(own, DRM_IOCTL_SET_MASTER, 0) != 0) fail(card.c_str());
  std::puts("taken");
  std::fflush(stdout);
  for (;;)
    ::pause();
}
