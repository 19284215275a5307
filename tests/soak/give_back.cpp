// Preloaded into a daemon by the soak: while there is the file $GIVE_BACK, what the daemon has freed goes
// back to the kernel, and what is left is what it holds.
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

// The daemon's signals are for the daemon's own threads.
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
