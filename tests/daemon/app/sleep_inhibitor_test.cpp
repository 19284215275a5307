#include "daemon/app/sleep_inhibitor.hpp"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include "hw/virtual_clock.hpp"
#include "tests/catch.hpp"

namespace {

// An authority whose locks are write ends of pipes, as logind's are.
class FakeAuthority final : public SleepAuthority {
 public:
  void take(Lock lock, Taken taken) override {
    asked.push_back(lock);
    waiting.push_back([this, lock, taken = std::move(taken)] {
      if (refuses[static_cast<std::size_t>(lock)]) return taken(FileDescriptor(), "Permission denied");
      int ends[2];
      REQUIRE(::pipe2(ends, O_CLOEXEC) == 0);
      locks[static_cast<std::size_t>(lock)] = FileDescriptor(ends[0]);
      taken(FileDescriptor(ends[1]), {});
    });
  }
  void on_sleep(std::function<void(bool)> call) override { sleep = std::move(call); }

  void answer() {
    for (const auto& each : std::exchange(waiting, {}))
      each();
  }
  [[nodiscard]] bool held(Lock lock) const {
    const FileDescriptor& end = locks[static_cast<std::size_t>(lock)];
    pollfd hung_up{end.get(), POLLIN, 0};
    return end.valid() && ::poll(&hung_up, 1, 0) == 0;
  }

  std::array<bool, 2> refuses{};
  std::vector<Lock> asked;
  std::function<void(bool)> sleep;

 private:
  std::vector<std::function<void()>> waiting;
  std::array<FileDescriptor, 2> locks;
};

struct SleepInhibitorFixture : SleepingPrint {
  FakeAuthority authority;
  VirtualClock clock;
  int interruptions = 0;
  bool is_dark = false;
  std::vector<std::string> reported;
  SleepInhibitor inhibitor{authority, clock, *this};

  void interrupt() override { ++interruptions; }
  [[nodiscard]] bool dark() const override { return is_dark; }
  void unguarded(const std::string& why) override { reported.push_back(why); }
  [[nodiscard]] bool block() const { return authority.held(SleepAuthority::Lock::Block); }
  [[nodiscard]] bool delay() const { return authority.held(SleepAuthority::Lock::Delay); }
};

}  // namespace

TEST_CASE_METHOD(SleepInhibitorFixture, "The computer is kept awake only while a print runs") {
  CHECK(authority.asked.empty());
  inhibitor.hold(true);
  inhibitor.hold(true);
  authority.answer();
  CHECK(authority.asked.size() == 2);
  CHECK(block());
  CHECK(delay());
  inhibitor.hold(false);
  CHECK_FALSE(block());
  CHECK_FALSE(delay());
}

TEST_CASE_METHOD(SleepInhibitorFixture, "A lock granted after the print's end is released at once") {
  inhibitor.hold(true);
  inhibitor.hold(false);
  authority.answer();
  CHECK_FALSE(block());
  CHECK_FALSE(delay());
  CHECK(reported.empty());
}

TEST_CASE_METHOD(SleepInhibitorFixture, "Sleep is delayed until the light of the interrupted print is off") {
  authority.refuses[static_cast<std::size_t>(SleepAuthority::Lock::Block)] = true;
  inhibitor.hold(true);
  authority.answer();
  CHECK(reported.empty());  // one of the two is enough
  authority.sleep(true);
  CHECK(interruptions == 1);
  CHECK(delay());
  REQUIRE(clock.run_next());
  CHECK(delay());
  is_dark = true;
  REQUIRE(clock.run_next());
  CHECK_FALSE(delay());

  // After the wake-up the print still exists and may be resumed.
  authority.sleep(false);
  authority.answer();
  CHECK(delay());
}

TEST_CASE_METHOD(SleepInhibitorFixture, "Sleep while nothing prints interrupts nothing") {
  authority.sleep(true);
  authority.sleep(false);
  CHECK(interruptions == 0);
  CHECK(authority.asked.empty());
}

TEST_CASE_METHOD(SleepInhibitorFixture, "A print without a lock is reported once") {
  authority.refuses = {true, true};
  for (int print = 0; print < 3; ++print) {
    inhibitor.hold(true);
    authority.answer();
    inhibitor.hold(false);
  }
  CHECK(reported == std::vector<std::string>{"Permission denied"});
}
