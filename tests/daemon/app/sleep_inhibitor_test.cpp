#include "daemon/app/sleep_inhibitor.hpp"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <array>
#include <optional>
#include <vector>

#include "hw/virtual_clock.hpp"
#include "tests/catch.hpp"

using namespace contourd;
using namespace std::chrono_literals;

namespace {

// Its locks are the writing ends of pipes, as logind's are.
class MadeUpAuthority final : public SleepAuthority {
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

struct Bench {
  MadeUpAuthority authority;
  VirtualClock clock;
  int interruptions = 0;
  bool dark = false;
  std::vector<std::string> told;
  SleepInhibitor inhibitor{authority,
                           clock,
                           {.interrupt = [this] { ++interruptions; },
                            .dark = [this] { return dark; },
                            .unguarded = [this](const std::string& why) { told.push_back(why); }}};

  [[nodiscard]] bool block() const { return authority.held(SleepAuthority::Lock::Block); }
  [[nodiscard]] bool delay() const { return authority.held(SleepAuthority::Lock::Delay); }
};

}  // namespace

TEST_CASE("The computer is kept awake from a print's begin to its end, and not otherwise") {
  Bench bench;
  CHECK(bench.authority.asked.empty());
  bench.inhibitor.hold(true);
  bench.inhibitor.hold(true);
  bench.authority.answer();
  CHECK(bench.authority.asked.size() == 2);
  CHECK(bench.block());
  CHECK(bench.delay());
  bench.inhibitor.hold(false);
  CHECK_FALSE(bench.block());
  CHECK_FALSE(bench.delay());
}

TEST_CASE("A lock that comes after the print's end is given up at once") {
  Bench bench;
  bench.inhibitor.hold(true);
  bench.inhibitor.hold(false);
  bench.authority.answer();
  CHECK_FALSE(bench.block());
  CHECK_FALSE(bench.delay());
  CHECK(bench.told.empty());
}

TEST_CASE("A computer that goes to sleep waits until the interrupted print is dark") {
  Bench bench;
  bench.authority.refuses[static_cast<std::size_t>(SleepAuthority::Lock::Block)] = true;
  bench.inhibitor.hold(true);
  bench.authority.answer();
  CHECK(bench.told.empty());  // one of the two is enough
  bench.authority.sleep(true);
  CHECK(bench.interruptions == 1);
  CHECK(bench.delay());
  REQUIRE(bench.clock.run_next());
  CHECK(bench.delay());
  bench.dark = true;
  REQUIRE(bench.clock.run_next());
  CHECK_FALSE(bench.delay());

  // Awake, the print is still there, and may be resumed.
  bench.authority.sleep(false);
  bench.authority.answer();
  CHECK(bench.delay());
}

TEST_CASE("A computer that sleeps while nothing prints interrupts nothing") {
  Bench bench;
  bench.authority.sleep(true);
  bench.authority.sleep(false);
  CHECK(bench.interruptions == 0);
  CHECK(bench.authority.asked.empty());
}

TEST_CASE("That nobody keeps the computer awake is told once") {
  Bench bench;
  bench.authority.refuses = {true, true};
  for (int print = 0; print < 3; ++print) {
    bench.inhibitor.hold(true);
    bench.authority.answer();
    bench.inhibitor.hold(false);
  }
  CHECK(bench.told == std::vector<std::string>{"Permission denied"});
}
