// Tests the daemon's side, on a virtual clock; the test is the process at the other end of the socket.
#include "hw/watchdog/light_watchdog.hpp"

#include <fcntl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <map>
#include <system_error>

#include "hw/virtual_clock.hpp"
#include "tests/catch.hpp"

using namespace contourd;
using namespace std::chrono_literals;

namespace {

// Calls the function that watches a descriptor when the test says so.
class Readiness final : public DescriptorWatcher {
 public:
  [[nodiscard]] std::unique_ptr<Watch> when_readable(int, std::function<void()> call) override {
    auto watch = std::make_unique<Counted>(*this);
    call_ = std::move(call);
    return watch;
  }
  void serve() {
    if (const auto call = call_) call();
  }

 private:
  struct Counted final : Watch {
    explicit Counted(Readiness& readiness) : owner(readiness) {}
    ~Counted() override { owner.call_ = nullptr; }
    Readiness& owner;
  };
  std::function<void()> call_;
};

struct Bench {
  explicit Bench(bool starts = true) : can_start(starts) {
    watchdog.emplace(clock, readiness, [this] { return start(); });
    watchdog->on_trouble([this](const std::string& what) { troubles.push_back(what); });
    watchdog->on_recovery([this](const std::string& problem) { recovered.push_back(problem); });
  }

  LightWatchdog::Process start() {
    ++started;
    if (!can_start) throw std::system_error(EAGAIN, std::generic_category(), "/proc/self/exe");
    int ends[2];
    REQUIRE(::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) == 0);
    process = FileDescriptor(ends[1]);
    if (gets_ready) reply(WatchdogMessageType::Ready);
    return {FileDescriptor(ends[0]), -1};
  }

  void reply(WatchdogMessageType type, std::uint64_t exposure = 0, LightTrip trip = LightTrip::None) {
    WatchdogReply message{};
    message.type = type;
    message.exposure = exposure;
    message.trip = trip;
    message.at = clock.now();
    message.line_off = trip != LightTrip::None;
    message.no_priority = no_priority;
    CHECK(send_message(process.get(), message));
  }

  // Returns the types of the messages that came; the last ExposureMessage is kept.
  std::vector<WatchdogMessageType> received() {
    std::vector<WatchdogMessageType> came;
    WatchdogPacket packet;
    while (receive_packet(process.get(), packet) == Received::Packet) {
      came.push_back(packet.type().value());
      if (const auto exposure = packet.as<ExposureMessage>()) last = *exposure;
      if (packet.descriptor.valid()) ++descriptors[came.back()];
      if (answers &&
          (came.back() == WatchdogMessageType::Arm || came.back() == WatchdogMessageType::Heartbeat))
        reply(WatchdogMessageType::Heard, last.exposure.number);
    }
    return came;
  }
  // Lets the daemon read its messages, and runs the calls that this leads to at once.
  void hear() {
    readiness.serve();
    run_for(1us);
  }
  // Lets time pass, during which the process answers if `answers` is set.
  void run_for(Duration duration) {
    const TimePoint until = clock.now() + duration;
    // A timer that makes the clock reach `until`.
    bool over = false;
    const auto end = clock.call_at(until, [&] { over = true; });
    while (!over && clock.run_next()) {
      for (const WatchdogMessageType type : received())
        ++words[type];
      readiness.serve();
    }
  }
  bool arm(Duration exposure = 2s) {
    bool armed = false;
    watchdog->arm(exposure, [&] { armed = true; });
    for (const WatchdogMessageType type : received())
      ++words[type];
    readiness.serve();
    return armed;
  }

  bool can_start = true, gets_ready = true, answers = true;
  int no_priority = 0, started = 0;
  std::vector<std::string> troubles, recovered;
  std::map<WatchdogMessageType, int> words, descriptors;
  ExposureMessage last{};
  FileDescriptor process;
  VirtualClock clock;
  Readiness readiness;
  std::optional<LightWatchdog> watchdog;
};

}  // namespace

TEST_CASE("An exposure is armed when the watchdog confirms that it has heard, and not before") {
  Bench bench;
  CHECK(bench.watchdog->problem().empty());
  bench.answers = false;
  bool armed = false;
  bench.watchdog->arm(2s, [&] { armed = true; });
  bench.readiness.serve();
  CHECK_FALSE(armed);
  REQUIRE(bench.received() == std::vector{WatchdogMessageType::Arm});
  bench.reply(WatchdogMessageType::Heard, bench.last.exposure.number + 1);  // another exposure's
  bench.readiness.serve();
  CHECK_FALSE(armed);
  bench.reply(WatchdogMessageType::Heard, bench.last.exposure.number);
  bench.readiness.serve();
  CHECK(armed);
}

TEST_CASE("The daemon sends a heartbeat every 50 ms, from arming until darkness is confirmed") {
  Bench bench;
  REQUIRE(bench.arm());
  bench.run_for(1010ms);
  CHECK(bench.words[WatchdogMessageType::Heartbeat] == 20);
  CHECK(bench.last.sent == TimePoint{1s});
  bench.watchdog->disarm();
  CHECK(bench.received() == std::vector{WatchdogMessageType::Disarm});
  bench.run_for(1s);
  CHECK(bench.words[WatchdogMessageType::Heartbeat] == 20);
  CHECK(bench.troubles.empty());
}

TEST_CASE("The end that is sent moves on until light on was sent, and is the exposure's from then on") {
  Bench bench;
  REQUIRE(bench.arm(2s));
  bench.run_for(500ms);
  CHECK(bench.last.exposure.end == bench.last.sent + 2s);
  const TimePoint end = bench.clock.now() + 2s;
  bench.watchdog->begins(end);
  bench.run_for(1s);
  CHECK(bench.last.exposure.end == end);
  CHECK_FALSE(bench.last.exposure.off_asked);
  bench.watchdog->off_asked();
  CHECK(bench.received() == std::vector{WatchdogMessageType::Heartbeat});  // at once
  CHECK(bench.last.exposure.off_asked);
}

TEST_CASE("A trip of the watchdog is reported, and it watches on until darkness is confirmed") {
  Bench bench;
  REQUIRE(bench.arm());
  bench.reply(WatchdogMessageType::Tripped, bench.last.exposure.number, LightTrip::Silence);
  bench.hear();
  REQUIRE(bench.troubles.size() == 1);
  CHECK(bench.troubles[0] ==
        "the light watchdog has turned the light off: contourd had not answered in time");
  CHECK(bench.watchdog->problem().empty());
  REQUIRE(bench.watchdog->trip());
  CHECK(bench.watchdog->trip()->at == TimePoint{});
  CHECK(bench.watchdog->trip()->line_off);
  bench.run_for(110ms);
  CHECK(bench.words[WatchdogMessageType::Heartbeat] == 2);
  bench.watchdog->disarm();
  CHECK(bench.arm());
}

TEST_CASE("A trip of an exposure that is over is ignored") {
  Bench bench;
  REQUIRE(bench.arm());
  const std::uint64_t number = bench.last.exposure.number;
  bench.watchdog->disarm();
  bench.reply(WatchdogMessageType::Tripped, number, LightTrip::Silence);
  bench.hear();
  CHECK(bench.troubles.empty());
}

TEST_CASE(
    "A watchdog that dies in an exposure is reported at once, and one that dies otherwise is replaced") {
  Bench bench;
  REQUIRE(bench.arm());
  bench.process = FileDescriptor();
  bench.hear();
  REQUIRE(bench.troubles.size() == 1);
  CHECK(bench.troubles[0] == "the light watchdog has died; no light is turned on without it");
  CHECK(bench.watchdog->problem() == bench.troubles[0]);
  bench.run_for(LightWatchdog::kStartLater);
  CHECK(bench.started == 2);
  CHECK(bench.watchdog->problem().empty());
  CHECK(bench.recovered == bench.troubles);

  bench.process = FileDescriptor();
  bench.hear();
  CHECK(bench.troubles.size() == 1);
  CHECK_FALSE(bench.watchdog->problem().empty());
}

TEST_CASE("An exposure that is requested without a watchdog is armed by the next one, or not at all") {
  Bench bench;
  bench.process = FileDescriptor();
  bench.readiness.serve();
  bench.gets_ready = false;
  bool armed = false;
  bench.watchdog->arm(2s, [&] { armed = true; });
  SECTION("in time") {
    bench.run_for(200ms);
    CHECK_FALSE(armed);
    bench.clock.run_next();
  }
  SECTION("too late") {
    bench.run_for(1s);
    CHECK(bench.troubles.size() == 1);
    CHECK_FALSE(armed);
    bench.watchdog->disarm();
  }
  CHECK_FALSE(armed);
}

TEST_CASE("A watchdog that does not answer counts as dead after ten heartbeats") {
  Bench bench;
  REQUIRE(bench.arm());
  bench.answers = false;
  bench.run_for(400ms);
  CHECK(bench.troubles.empty());
  bench.run_for(200ms);
  REQUIRE(bench.troubles.size() == 1);
  CHECK(bench.troubles[0] == "the light watchdog does not answer; no light is turned on without it");
}

TEST_CASE("Messages to a dead watchdog are lost, and its death is reported only from the event loop") {
  Bench bench;
  REQUIRE(bench.arm());
  bench.process = FileDescriptor();
  bench.watchdog->off_asked();
  CHECK_FALSE(bench.watchdog->trip());
  CHECK_FALSE(bench.watchdog->problem().empty());
  CHECK(bench.troubles.empty());
  bench.run_for(1us);
  CHECK(bench.troubles.size() == 1);
}

TEST_CASE("Descriptors that turn the light off are handed over at once, and again to each new watchdog") {
  Bench bench;
  const FileDescriptor device(::open("/dev/null", O_RDWR | O_CLOEXEC));
  bench.watchdog->set_line(device.get());
  bench.watchdog->set_serial({device.get(), "~0002 1\r", 108ms});
  LightDisplayPath display;
  display.descriptor = device.get();
  bench.watchdog->set_display(display);
  CHECK(bench.received() ==
        std::vector{WatchdogMessageType::Line, WatchdogMessageType::Serial, WatchdogMessageType::Display});
  CHECK(bench.descriptors.size() == 3);
  bench.watchdog->set_line(-1);
  CHECK(bench.received() == std::vector{WatchdogMessageType::Line});
  CHECK(bench.descriptors[WatchdogMessageType::Line] == 1);  // the last message came without a descriptor

  bench.process = FileDescriptor();
  bench.readiness.serve();
  bench.run_for(LightWatchdog::kStartLater);
  CHECK(bench.words[WatchdogMessageType::Line] == 0);
  CHECK(bench.words[WatchdogMessageType::Serial] == 1);
  CHECK(bench.words[WatchdogMessageType::Display] == 1);
}

TEST_CASE("A watchdog that cannot be started is tried again, and says why there is no light") {
  Bench bench(false);
  CHECK(bench.watchdog->problem().find("cannot be started: /proc/self/exe") != std::string::npos);
  bench.can_start = true;
  bench.no_priority = EPERM;
  bench.run_for(LightWatchdog::kStartLater);
  CHECK(bench.watchdog->problem().empty());
  REQUIRE(bench.watchdog->refusals().size() == 1);
  CHECK(bench.watchdog->refusals()[0].find("real-time priority") != std::string::npos);
}

TEST_CASE("A packet that is not a watchdog's answer is ignored") {
  Bench bench;
  REQUIRE(bench.arm());
  CHECK(::write(bench.process.get(), "garbage", 7) == 7);
  CHECK(send_message(bench.process.get(), ExposureMessage{}));
  bench.readiness.serve();
  bench.run_for(200ms);
  CHECK(bench.troubles.empty());
}
