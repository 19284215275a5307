// Tests the daemon's side, on a virtual clock; the test is the process at the other end of the socket.
#include "hw/watchdog/light_watchdog.hpp"

#include <fcntl.h>
#include <sys/socket.h>
#include <unistd.h>

#include "tests/catch.hpp"
#include "tests/hw/virtual_time_fixture.hpp"
#include "tests/hw/watchdog/ready_watchdog.hpp"

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

struct LightWatchdogFixture : testing::VirtualTimeFixture {
  explicit LightWatchdogFixture(bool starts = true) : can_start(starts) {
    watchdog.emplace(clock, readiness, [this] { return start(); });
    watchdog->on_trouble([this](const std::string& what) { troubles.push_back(what); });
    watchdog->on_recovery([this](const std::string& problem) { recovered.push_back(problem); });
  }

  LightWatchdog::Process start() {
    ++started;
    if (!can_start) throw std::system_error(EAGAIN, std::generic_category(), "/proc/self/exe");
    auto [daemon, far] = testing::socket_pair(SOCK_SEQPACKET);
    process = std::move(far);
    if (gets_ready) reply(WatchdogMessageType::Ready);
    return {std::move(daemon), -1};
  }

  void reply(WatchdogMessageType type, std::uint64_t exposure = 0, LightTrip trip = LightTrip::None) {
    WatchdogReply message{};
    message.type = type;
    message.exposure = exposure;
    message.trip = trip;
    message.at = clock.now();
    message.line_off = trip != LightTrip::None;
    message.no_priority = no_priority;
    testing::send_reply(process, message);
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
    pass(duration, [this] { serve(); });
  }
  // Counts the messages that came, and lets the daemon read the answers.
  void serve() {
    for (const WatchdogMessageType type : received())
      ++words[type];
    readiness.serve();
  }
  bool arm(Duration exposure = 2s) {
    bool armed = false;
    watchdog->arm(exposure, [&] { armed = true; });
    serve();
    return armed;
  }

  bool can_start = true, gets_ready = true, answers = true;
  int no_priority = 0, started = 0;
  std::vector<std::string> troubles, recovered;
  std::map<WatchdogMessageType, int> words, descriptors;
  ExposureMessage last{};
  FileDescriptor process;
  Readiness readiness;
  std::optional<LightWatchdog> watchdog;
};

}  // namespace

TEST_CASE_METHOD(LightWatchdogFixture,
                 "An exposure is armed when the watchdog confirms that it has heard, and not before") {
  CHECK(watchdog->problem().empty());
  answers = false;
  bool armed = false;
  watchdog->arm(2s, [&] { armed = true; });
  readiness.serve();
  CHECK_FALSE(armed);
  REQUIRE(received() == std::vector{WatchdogMessageType::Arm});
  reply(WatchdogMessageType::Heard, last.exposure.number + 1);  // another exposure's
  readiness.serve();
  CHECK_FALSE(armed);
  reply(WatchdogMessageType::Heard, last.exposure.number);
  readiness.serve();
  CHECK(armed);
}

TEST_CASE_METHOD(LightWatchdogFixture,
                 "The daemon sends a heartbeat every 50 ms, from arming until darkness is confirmed") {
  REQUIRE(arm());
  run_for(1010ms);
  CHECK(words[WatchdogMessageType::Heartbeat] == 20);
  CHECK(last.sent == TimePoint{1s});
  watchdog->disarm();
  CHECK(received() == std::vector{WatchdogMessageType::Disarm});
  run_for(1s);
  CHECK(words[WatchdogMessageType::Heartbeat] == 20);
  CHECK(troubles.empty());
}

TEST_CASE_METHOD(
    LightWatchdogFixture,
    "The end that is sent moves on until light on was sent, and is the exposure's from then on") {
  REQUIRE(arm(2s));
  run_for(500ms);
  CHECK(last.exposure.end == last.sent + 2s);
  const TimePoint end = clock.now() + 2s;
  watchdog->begins(end);
  run_for(1s);
  CHECK(last.exposure.end == end);
  CHECK_FALSE(last.exposure.off_asked);
  watchdog->off_asked();
  CHECK(received() == std::vector{WatchdogMessageType::Heartbeat});  // at once
  CHECK(last.exposure.off_asked);
}

TEST_CASE_METHOD(LightWatchdogFixture,
                 "A trip of the watchdog is reported, and it watches on until darkness is confirmed") {
  REQUIRE(arm());
  reply(WatchdogMessageType::Tripped, last.exposure.number, LightTrip::Silence);
  hear();
  REQUIRE(troubles.size() == 1);
  CHECK(troubles[0] == "the light watchdog has turned the light off: contourd had not answered in time");
  CHECK(watchdog->problem().empty());
  REQUIRE(watchdog->trip());
  CHECK(watchdog->trip()->at == TimePoint{});
  CHECK(watchdog->trip()->line_off);
  run_for(110ms);
  CHECK(words[WatchdogMessageType::Heartbeat] == 2);
  watchdog->disarm();
  CHECK(arm());
}

TEST_CASE_METHOD(LightWatchdogFixture, "A trip of an exposure that is over is ignored") {
  REQUIRE(arm());
  const std::uint64_t number = last.exposure.number;
  watchdog->disarm();
  reply(WatchdogMessageType::Tripped, number, LightTrip::Silence);
  hear();
  CHECK(troubles.empty());
}

TEST_CASE_METHOD(
    LightWatchdogFixture,
    "A watchdog that dies in an exposure is reported at once, and one that dies otherwise is replaced") {
  REQUIRE(arm());
  process = FileDescriptor();
  hear();
  REQUIRE(troubles.size() == 1);
  CHECK(troubles[0] == "the light watchdog has died; no light is turned on without it");
  CHECK(watchdog->problem() == troubles[0]);
  run_for(LightWatchdog::kStartLater);
  CHECK(started == 2);
  CHECK(watchdog->problem().empty());
  CHECK(recovered == troubles);

  process = FileDescriptor();
  hear();
  CHECK(troubles.size() == 1);
  CHECK_FALSE(watchdog->problem().empty());
}

TEST_CASE_METHOD(LightWatchdogFixture,
                 "An exposure that is requested without a watchdog is armed by the next one, or not at all") {
  process = FileDescriptor();
  readiness.serve();
  gets_ready = false;
  bool armed = false;
  watchdog->arm(2s, [&] { armed = true; });
  SECTION("in time") {
    run_for(200ms);
    CHECK_FALSE(armed);
    clock.run_next();
  }
  SECTION("too late") {
    run_for(1s);
    CHECK(troubles.size() == 1);
    CHECK_FALSE(armed);
    watchdog->disarm();
  }
  CHECK_FALSE(armed);
}

TEST_CASE_METHOD(LightWatchdogFixture,
                 "A watchdog that does not answer counts as dead after ten heartbeats") {
  REQUIRE(arm());
  answers = false;
  run_for(400ms);
  CHECK(troubles.empty());
  run_for(200ms);
  REQUIRE(troubles.size() == 1);
  CHECK(troubles[0] == "the light watchdog does not answer; no light is turned on without it");
}

TEST_CASE_METHOD(LightWatchdogFixture,
                 "Messages to a dead watchdog are lost, and its death is reported only from the event loop") {
  REQUIRE(arm());
  process = FileDescriptor();
  watchdog->off_asked();
  CHECK_FALSE(watchdog->trip());
  CHECK_FALSE(watchdog->problem().empty());
  CHECK(troubles.empty());
  run_for(1us);
  CHECK(troubles.size() == 1);
}

TEST_CASE_METHOD(
    LightWatchdogFixture,
    "Descriptors that turn the light off are handed over at once, and again to each new watchdog") {
  const FileDescriptor device(::open("/dev/null", O_RDWR | O_CLOEXEC));
  watchdog->set_line(device.get());
  watchdog->set_serial({device.get(), "~0002 1\r", 108ms});
  LightDisplayPath display;
  display.descriptor = device.get();
  watchdog->set_display(display);
  CHECK(received() ==
        std::vector{WatchdogMessageType::Line, WatchdogMessageType::Serial, WatchdogMessageType::Display});
  CHECK(descriptors.size() == 3);
  watchdog->set_line(-1);
  CHECK(received() == std::vector{WatchdogMessageType::Line});
  CHECK(descriptors[WatchdogMessageType::Line] == 1);  // the last message came without a descriptor

  process = FileDescriptor();
  readiness.serve();
  run_for(LightWatchdog::kStartLater);
  CHECK(words[WatchdogMessageType::Line] == 0);
  CHECK(words[WatchdogMessageType::Serial] == 1);
  CHECK(words[WatchdogMessageType::Display] == 1);
}

TEST_CASE("A watchdog that cannot be started is tried again, and says why there is no light") {
  LightWatchdogFixture fixture(false);
  CHECK(fixture.watchdog->problem().find("cannot be started: /proc/self/exe") != std::string::npos);
  fixture.can_start = true;
  fixture.no_priority = EPERM;
  fixture.run_for(LightWatchdog::kStartLater);
  CHECK(fixture.watchdog->problem().empty());
  REQUIRE(fixture.watchdog->refusals().size() == 1);
  CHECK(fixture.watchdog->refusals()[0].find("real-time priority") != std::string::npos);
}

TEST_CASE_METHOD(LightWatchdogFixture, "A packet that is not a watchdog's answer is ignored") {
  REQUIRE(arm());
  CHECK(::write(process.get(), "garbage", 7) == 7);
  CHECK(send_message(process.get(), ExposureMessage{}));
  readiness.serve();
  run_for(200ms);
  CHECK(troubles.empty());
}
