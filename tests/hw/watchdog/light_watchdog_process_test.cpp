// Tests the real process, with a socket pair in a serial port's place. No test waits for a time to pass: each
// waits for what is to happen, up to kPatienceMs.
#include "hw/watchdog/light_watchdog_process.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/catch.hpp"
#include "tests/hw/watchdog/socket_pair.hpp"

namespace {

constexpr int kPatienceMs = 20'000;  // for a machine that is very busy
constexpr Duration kGap = 30ms;
const std::string kOff = "OFF\r";

TimePoint now() {
  return std::chrono::time_point_cast<Duration>(std::chrono::steady_clock::now());
}

bool readable(const FileDescriptor& end) {
  pollfd waited{end.get(), POLLIN, 0};
  return ::poll(&waited, 1, kPatienceMs) == 1;
}

// The far end of a serial port.
struct SerialLine {
  SerialLine() { std::tie(port, line) = socket_pair(SOCK_STREAM); }
  // Returns all bytes that come until `size` bytes are there, or no process holds the port any more.
  std::string heard(std::size_t size) {
    std::string all;
    std::array<char, 64> bytes;
    while (all.size() < size) {
      REQUIRE(readable(line));
      const ssize_t count = ::read(line.get(), bytes.data(), std::min(bytes.size(), size - all.size()));
      if (count <= 0) break;
      all.append(bytes.data(), static_cast<std::size_t>(count));
    }
    return all;
  }
  [[nodiscard]] bool has_heard_something() const {
    pollfd waited{line.get(), POLLIN, 0};
    return ::poll(&waited, 1, 0) == 1;
  }
  FileDescriptor port, line;
};

// Runs in a forked child without the test's descriptors, as if the program had been started again.
int serve_alone(const FileDescriptor& socket) {
  ::close_range(3, static_cast<unsigned>(socket.get()) - 1, 0);
  return serve_light_watchdog(socket.get());
}

// A light watchdog, forked, and the daemon's end of its socket.
struct WatchdogProcess {
  WatchdogProcess() {
    auto [ours, its] = socket_pair(SOCK_SEQPACKET);
    process = ::fork();
    REQUIRE(process >= 0);
    if (process == 0) ::_exit(serve_alone(its));
    socket = std::move(ours);
    REQUIRE(reply().type == WatchdogMessageType::Ready);
  }
  // A watchdog that another process has forked.
  explicit WatchdogProcess(FileDescriptor ours) : socket(std::move(ours)) {}
  ~WatchdogProcess() {
    socket = FileDescriptor();
    if (process > 0) ::kill(process, SIGKILL);
    if (process > 0) ::waitpid(process, nullptr, 0);
  }

  WatchdogReply reply() {
    WatchdogPacket packet;
    REQUIRE(readable(socket));
    REQUIRE(receive_packet(socket.get(), packet) == Received::Packet);
    return packet.as<WatchdogReply>().value();
  }
  void give(const SerialLine& projector) {
    SerialMessage message{};
    message.type = WatchdogMessageType::Serial;
    message.size = static_cast<std::uint32_t>(kOff.size());
    message.gap = kGap;
    kOff.copy(message.light_off.data(), kOff.size());
    REQUIRE(send_message(socket.get(), message, projector.port.get()));
  }
  void say(WatchdogMessageType type, Duration until_end, bool off_asked = false) {
    REQUIRE(
        send_message(socket.get(), ExposureMessage{type, {exposure, now() + until_end, off_asked}, now()}));
  }
  void arm(Duration exposure_time = 1h) {
    ++exposure;
    say(WatchdogMessageType::Arm, exposure_time);
    const WatchdogReply answer = reply();
    REQUIRE(answer.type == WatchdogMessageType::Heard);
    REQUIRE(answer.exposure == exposure);
  }
  // Waits for the process to end, and returns its exit status.
  int ended() {
    int status = -1;
    REQUIRE(::waitpid(std::exchange(process, -1), &status, 0) > 0);
    return status;
  }

  pid_t process = -1;
  FileDescriptor socket;
  std::uint64_t exposure = 0;
};

// A watchdog that has been given a projector's port, of which the test keeps a copy.
struct GivenProjector {
  GivenProjector() { watchdog.give(projector); }
  SerialLine projector;
  WatchdogProcess watchdog;
};

}  // namespace

TEST_CASE_METHOD(GivenProjector,
                 "A light watchdog whose daemon ends without a light on ends too, and sends nothing") {
  projector.port = FileDescriptor();
  watchdog.arm();
  watchdog.say(WatchdogMessageType::Disarm, 0s);
  watchdog.socket = FileDescriptor();
  CHECK(watchdog.ended() == 0);
  CHECK(projector.heard(1).empty());
}

TEST_CASE_METHOD(GivenProjector,
                 "When the daemon's end of the socket closes in an exposure, light off is sent thrice") {
  projector.port = FileDescriptor();
  watchdog.arm();
  const TimePoint closed = now();
  watchdog.socket = FileDescriptor();
  CHECK(projector.heard(100) == kOff + kOff + kOff);
  CHECK(now() - closed >= 2 * kGap);
  CHECK(watchdog.ended() == 0);
}

TEST_CASE_METHOD(GivenProjector, "A daemon that falls silent has its light turned off, and is informed") {
  const TimePoint armed = now();
  watchdog.arm();
  CHECK(projector.heard(kOff.size()) == kOff);
  CHECK(now() - armed >= LightDeadline::kMaxSilence);
  const WatchdogReply tripped = watchdog.reply();
  CHECK(tripped.type == WatchdogMessageType::Tripped);
  CHECK(tripped.trip == LightTrip::Silence);
  CHECK(tripped.exposure == watchdog.exposure);
  CHECK(projector.heard(2 * kOff.size()) == kOff + kOff);

  // The daemon is served again after that.
  watchdog.say(WatchdogMessageType::Disarm, 0s);
  watchdog.arm();
  CHECK_FALSE(projector.has_heard_something());
  CHECK(projector.heard(kOff.size()) == kOff);
  CHECK(watchdog.reply().trip == LightTrip::Silence);
}

TEST_CASE_METHOD(GivenProjector,
                 "A live daemon has its light turned off if it has not done so when the exposure is over") {
  TimePoint armed;
  LightTrip trip = LightTrip::Silence;
  // A test that was itself held up for that long counts as silent, and is tried again.
  for (int attempt = 0; attempt < 20 && trip == LightTrip::Silence; ++attempt) {
    watchdog.say(WatchdogMessageType::Disarm, 0s);
    armed = now();
    watchdog.arm(20ms);
    trip = LightTrip::None;
    while (trip == LightTrip::None && now() - armed < std::chrono::milliseconds{kPatienceMs}) {
      watchdog.say(WatchdogMessageType::Heartbeat, armed + 20ms - now());
      trip = watchdog.reply().trip;
    }
  }
  CHECK(trip == LightTrip::Overrun);
  CHECK(now() - armed >= 20ms + LightDeadline::kMaxOverrun);
  CHECK(projector.heard(kOff.size()) == kOff);
}

TEST_CASE_METHOD(GivenProjector, "The signals that end a daemon end no light watchdog") {
  projector.port = FileDescriptor();
  for (const int signal : {SIGTERM, SIGINT, SIGHUP, SIGQUIT, SIGABRT, SIGPIPE, SIGALRM, SIGUSR1})
    REQUIRE(::kill(watchdog.process, signal) == 0);
  watchdog.arm();
  watchdog.socket = FileDescriptor();
  CHECK(projector.heard(3 * kOff.size()) == kOff + kOff + kOff);
  CHECK(watchdog.ended() == 0);
}

TEST_CASE("A new port replaces the old one, which is closed") {
  SerialLine before, after;
  WatchdogProcess watchdog;
  watchdog.give(before);
  watchdog.give(after);
  before.port = FileDescriptor();
  after.port = FileDescriptor();
  CHECK(before.heard(1).empty());  // the end of the stream: no process holds the port
  watchdog.arm();
  CHECK(after.heard(kOff.size()) == kOff);
}

TEST_CASE_METHOD(GivenProjector,
                 "A port that is withdrawn is closed, and the light watchdog goes on without it") {
  projector.port = FileDescriptor();
  SerialMessage none{};
  none.type = WatchdogMessageType::Serial;
  REQUIRE(send_message(watchdog.socket.get(), none));
  CHECK(projector.heard(1).empty());
  watchdog.arm();
  CHECK(watchdog.reply().trip == LightTrip::Silence);
}

TEST_CASE("A packet that is not a message is ignored, and its descriptor is closed") {
  SerialLine stray, projector;
  WatchdogProcess watchdog;
  watchdog.give(projector);
  const std::string long_one(400, 'x'), longest(4'000, 'x');
  for (const std::string& bytes : {std::string("x"), std::string("garbage"), long_one, longest})
    REQUIRE(send_packet(watchdog.socket.get(), bytes.data(), bytes.size(), stray.port.get()));
  ExposureMessage odd{};
  odd.type = WatchdogMessageType::Serial;
  REQUIRE(send_message(watchdog.socket.get(), odd, stray.port.get()));
  SerialMessage lies{};
  lies.type = WatchdogMessageType::Line;
  REQUIRE(send_message(watchdog.socket.get(), lies));
  stray.port = FileDescriptor();
  watchdog.arm();
  CHECK(stray.heard(1).empty());
  CHECK(projector.heard(kOff.size()) == kOff);
}

TEST_CASE("A message that claims more bytes than it has room for sends no more than that") {
  SerialLine projector;
  WatchdogProcess watchdog;
  SerialMessage lies{};
  lies.type = WatchdogMessageType::Serial;
  lies.size = 1'000'000;
  lies.light_off.fill('o');
  REQUIRE(send_message(watchdog.socket.get(), lies, projector.port.get()));
  watchdog.arm();
  projector.port = FileDescriptor();
  watchdog.socket = FileDescriptor();
  CHECK(projector.heard(1'000'000).size() == 3 * SerialMessage::kMaxBytes);
}

namespace {

// A daemon's process that sends heartbeats until it is stopped or killed, with a watchdog of its own.
struct Daemon {
  explicit Daemon(SerialLine& projector) {
    auto [ours, its] = socket_pair(SOCK_SEQPACKET);
    auto [here, there] = socket_pair(SOCK_STREAM);
    watchdog = ::fork();
    if (watchdog == 0) ::_exit(serve_alone(its));
    its = FileDescriptor();
    process = ::fork();
    if (process == 0) ::_exit(heartbeat(ours, there, projector));
    REQUIRE(process > 0);
    report = std::move(here);
    projector.port = FileDescriptor();
  }
  ~Daemon() {
    report = FileDescriptor();
    for (const pid_t child : {process, watchdog}) {
      ::kill(child, SIGKILL);
      ::waitpid(child, nullptr, 0);
    }
  }

  // Sends heartbeats as a real daemon does, but five times as often, because a busy machine delays them.
  static int heartbeat(FileDescriptor& socket, FileDescriptor& to_test, SerialLine& projector) {
    WatchdogProcess watchdog(std::move(socket));
    watchdog.exposure = 1;
    watchdog.give(projector);
    projector.port = FileDescriptor();
    for (WatchdogMessageType type = WatchdogMessageType::Arm;; type = WatchdogMessageType::Heartbeat) {
      watchdog.say(type, 1h);
      ::poll(nullptr, 0, 10);  // a fifth of LightWatchdog::kHeartbeat
      WatchdogPacket packet;
      while (receive_packet(watchdog.socket.get(), packet) == Received::Packet) {
        const auto reply = packet.as<WatchdogReply>();
        const char kind = reply->type == WatchdogMessageType::Tripped ? 'T' : 'h';
        if (::write(to_test.get(), &kind, 1) != 1) return 1;
      }
    }
  }
  // Waits for that kind of report; false if it does not come.
  bool reports(char wanted) {
    char kind = 0;
    while (readable(report) && ::read(report.get(), &kind, 1) == 1) {
      if (kind == wanted) return true;
    }
    return false;
  }

  pid_t process = -1, watchdog = -1;
  FileDescriptor report;
};

}  // namespace

TEST_CASE(
    "A daemon that is stopped in an exposure has its light turned off, and learns that when it goes on") {
  SerialLine projector;
  Daemon daemon(projector);
  REQUIRE(daemon.reports('h'));
  CHECK_FALSE(projector.has_heard_something());
  REQUIRE(::kill(daemon.process, SIGSTOP) == 0);
  CHECK(projector.heard(kOff.size()) == kOff);
  REQUIRE(::kill(daemon.process, SIGCONT) == 0);
  CHECK(daemon.reports('T'));
}

TEST_CASE("A daemon that is killed in an exposure has its light turned off") {
  SerialLine projector;
  Daemon daemon(projector);
  REQUIRE(daemon.reports('h'));
  REQUIRE(::kill(daemon.process, SIGKILL) == 0);
  CHECK(projector.heard(100) == kOff + kOff + kOff);
}
