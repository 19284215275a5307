// Preloaded into the daemon by the soak. While the file $GIVE_BACK exists, memory that the daemon has freed
// is returned to the kernel, so that the remaining memory is what the daemon holds.
#include <malloc.h>
#include <pthread.h>
#include <signal.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <thread>

namespace {

void give_back_while_asked(const char* file) {
  for (;; std::this_thread::sleep_for(std::chrono::milliseconds(50))) {
    if (::access(file, F_OK) == 0) ::malloc_trim(0);
  }
}

// Blocks signals in this thread, so that the daemon's own threads get them.
__attribute__((constructor)) void start() {
  const char* const file = std::getenv("GIVE_BACK");
  if (file == nullptr) return;
  sigset_t all, before;
  sigfillset(&all);
  ::pthread_sigmask(SIG_SETMASK, &all, &before);
  std::thread(give_back_while_asked, file).detach();
  ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

}  // namespace
