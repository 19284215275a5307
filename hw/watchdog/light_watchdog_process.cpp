#include "hw/watchdog/light_watchdog_process.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sched.h>
#include <signal.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <string>
#include <system_error>

#include "hw/watchdog/light_deadline.hpp"
#include "hw/watchdog/light_paths.hpp"
#include "hw/watchdog/watchdog_message.hpp"

namespace contourd {
namespace {

// Priority above everything that is not real-time, and below the axis's threads, which never keep a processor
// for long.
constexpr int kPriority = 30;

TimePoint monotonic_now() noexcept {
  return std::chrono::time_point_cast<Duration>(std::chrono::steady_clock::now());
}

// Sets this process up. Returns the Ready message, with the errors of what the system refused.
WatchdogReply prepare(int socket) noexcept {
  // The service manager signals every process of the unit, and a terminal's Ctrl+C every process in it.
  sigset_t all;
  sigfillset(&all);
  sigprocmask(SIG_SETMASK, &all, nullptr);
  prctl(PR_SET_NAME, "contourd-light");
  prctl(PR_SET_TIMERSLACK, 1UL);
  close_range(static_cast<unsigned>(socket) + 1, ~0U, 0);

  WatchdogReply ready{};
  ready.type = WatchdogMessageType::Ready;
  sched_param parameter{};
  parameter.sched_priority = kPriority;
  if (sched_setscheduler(0, SCHED_FIFO, &parameter) != 0) ready.no_priority = errno;
  if (mlockall(MCL_CURRENT | MCL_FUTURE) != 0) ready.no_memory_lock = errno;
  return ready;
}

class LightWatchdogProcess {
 public:
  explicit LightWatchdogProcess(int socket) : socket_(socket) { deadline_.set_gap(paths_.gap()); }

  void run() noexcept {
    while (!act(deadline_.due(monotonic_now()))) {
      wait();
      hear_all();
    }
  }

 private:
  // True if the process is to end.
  bool act(const LightDeadline::Act& act) noexcept {
    const bool line_off = act.light_off && paths_.light_off();
    if (act.trip != LightTrip::None) reply(WatchdogMessageType::Tripped, act.trip, line_off);
    if (act.display_black) paths_.display_black();
    return act.end;
  }

  void wait() noexcept {
    const auto next = deadline_.next();
    const Duration left = next ? std::max(*next - monotonic_now(), Duration{0}) : Duration{0};
    const timespec time{static_cast<time_t>(left / std::chrono::seconds{1}),
                        static_cast<long>((left % std::chrono::seconds{1}).count())};
    pollfd readable{socket_, POLLIN, 0};
    ppoll(&readable, 1, next ? &time : nullptr, nullptr);
  }

  // Reads all pending messages before anything is judged by the time, because this process itself may have
  // been suspended.
  void hear_all() noexcept {
    WatchdogPacket packet;
    for (Received got = Received::Packet; socket_ >= 0 && got == Received::Packet;) {
      got = receive_packet(socket_, packet);
      if (got == Received::Packet) hear(packet);
      if (got == Received::End) hang_up();
    }
  }

  void hang_up() noexcept {
    socket_ = -1;  // poll() ignores -1; the other end is closed, and this one when the process ends
    deadline_.daemon_is_gone();
  }

  void hear(WatchdogPacket& packet) noexcept {
    if (paths_.take(packet)) return deadline_.set_gap(paths_.gap());
    const auto message = packet.as<ExposureMessage>();
    if (!message) return;
    const auto& [type, exposure, sent] = *message;
    if (type == WatchdogMessageType::Disarm) return deadline_.disarm(exposure.number);
    if (type == WatchdogMessageType::Arm) deadline_.arm(exposure, sent, monotonic_now());
    if (type == WatchdogMessageType::Heartbeat) deadline_.heartbeat(exposure, sent, monotonic_now());
    if (type == WatchdogMessageType::Arm || type == WatchdogMessageType::Heartbeat)
      reply(WatchdogMessageType::Heard);
  }

  // Does not wait: the replies to a daemon that does not read stay in the socket until it is full.
  void reply(WatchdogMessageType type, LightTrip trip = LightTrip::None,
             bool line_off = false) const noexcept {
    WatchdogReply reply{};
    reply.type = type;
    reply.trip = trip;
    reply.exposure = deadline_.exposure();
    reply.at = monotonic_now();
    reply.line_off = line_off;
    if (socket_ >= 0) (void)send_message(socket_, reply);
  }

  int socket_;
  LightPaths paths_;
  LightDeadline deadline_;
};

void throw_on_error(int error, const char* what) {
  if (error != 0) throw std::system_error(error, std::generic_category(), what);
}

constexpr int kSocket = 3;  // the first descriptor after the standard ones

// Descriptors and signal mask with which the child process starts.
class SpawnSettings {
 public:
  explicit SpawnSettings(int socket) {
    throw_on_error(posix_spawn_file_actions_init(&files_), "posix_spawn");
    throw_on_error(posix_spawnattr_init(&attributes_), "posix_spawn");
    for (int standard = 0; standard < kSocket; ++standard)
      throw_on_error(posix_spawn_file_actions_addopen(&files_, standard, "/dev/null", O_RDWR, 0),
                     "posix_spawn");
    throw_on_error(posix_spawn_file_actions_adddup2(&files_, socket, kSocket), "posix_spawn");
    // Block all signals from the child's first instruction on.
    sigset_t all;
    sigfillset(&all);
    throw_on_error(posix_spawnattr_setsigmask(&attributes_, &all), "posix_spawn");
    throw_on_error(posix_spawnattr_setflags(&attributes_, POSIX_SPAWN_SETSIGMASK), "posix_spawn");
  }
  SpawnSettings(const SpawnSettings&) = delete;
  SpawnSettings& operator=(const SpawnSettings&) = delete;
  ~SpawnSettings() {
    posix_spawnattr_destroy(&attributes_);
    posix_spawn_file_actions_destroy(&files_);
  }

  [[nodiscard]] const posix_spawn_file_actions_t* files() const { return &files_; }
  [[nodiscard]] const posix_spawnattr_t* attributes() const { return &attributes_; }

 private:
  posix_spawn_file_actions_t files_{};
  posix_spawnattr_t attributes_{};
};

}  // namespace

LightWatchdog::Process start_light_watchdog() {
  int ends[2];
  if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) != 0) throw_on_error(errno, "socketpair");
  LightWatchdog::Process process{FileDescriptor(ends[0]), -1};
  const FileDescriptor its_end(ends[1]);
  const SpawnSettings settings(its_end.get());
  std::string name = "contourd", option = kLightWatchdogOption, number = std::to_string(kSocket);
  char* const arguments[] = {name.data(), option.data(), number.data(), nullptr};
  throw_on_error(
      posix_spawn(&process.id, "/proc/self/exe", settings.files(), settings.attributes(), arguments, environ),
      "/proc/self/exe");
  return process;
}

int serve_light_watchdog(int socket) noexcept {
  const WatchdogReply ready = prepare(socket);
  // If the daemon has died meanwhile, run() notices it.
  (void)send_message(socket, ready);
  LightWatchdogProcess process(socket);
  process.run();
  return EXIT_SUCCESS;
}

}  // namespace contourd
