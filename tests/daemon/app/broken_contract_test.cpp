// Tests a process that breaks a contract while its light is on and its motor turns: a child process runs a
// machine with its own threads. This program's ioctl() replaces the kernel's and records the calls in memory
// shared by both processes.
#include "daemon/app/broken_contract.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cstdarg>
#include <new>
#include <thread>

#include "core/contract/expects.hpp"
#include "core/mask/mask.hpp"
#include "hw/gpio/axis_threads.hpp"
#include "hw/gpio/gpio_axis.hpp"
#include "hw/real_machine.hpp"
#include "hw/virtual_clock.hpp"
#include "tests/broken_contract.hpp"
#include "tests/catch.hpp"
#include "tests/hw/no_descriptors.hpp"
#include "tests/hw/plain_devices.hpp"
#include "tests/hw/watchdog/ready_watchdog.hpp"

namespace {

constexpr int kLightLine = 1'000'000, kCard = 1'000'001;
constexpr int kStepsBefore = 20;

struct Seen {
  std::atomic<bool> light{false};
  std::atomic<int> steps{0}, lines_off{0}, screens_black{0};
  std::atomic<bool> light_when_black{true};
  std::atomic<int> steps_when_black{-1}, steps_past_black{-1};
};
Seen* seen = nullptr;

// Simulates a driver that takes as long as 50 steps.
void take_long() {
  const TimePoint start = monotonic_now();
  while (monotonic_now() < start + 50ms) {
  }
}

int set_line_off() {
  seen->light = false;
  ++seen->lines_off;
  return 0;
}

int set_screen_black() {
  seen->light_when_black = seen->light.load();
  seen->steps_when_black = seen->steps.load();
  take_long();
  seen->steps_past_black = seen->steps.load();
  ++seen->screens_black;
  return 0;
}

class LightWire final : public CuttableLine {
 public:
  [[nodiscard]] bool set(bool active) noexcept override {
    seen->light = active;
    return true;
  }
  [[nodiscard]] bool cut() noexcept override { return set(false); }
  [[nodiscard]] int descriptor() const noexcept override { return kLightLine; }
};

class StepWire final : public OutputLine {
 public:
  // The stepping thread breaks a contract at step `breaking_step`; 0: never.
  explicit StepWire(int breaking_step) : breaking_step_(breaking_step) {}
  [[nodiscard]] bool set(bool active) noexcept override {
    if (active) expects(++seen->steps != breaking_step_, "the stepping thread makes no mistake");
    return true;
  }

 private:
  int breaking_step_;
};

class QuietWire final : public OutputLine {
 public:
  [[nodiscard]] bool set(bool) noexcept override { return true; }
};

class OpenSwitch final : public InputLine {
 public:
  [[nodiscard]] int descriptor() const noexcept override { return -1; }
  [[nodiscard]] std::optional<bool> level() noexcept override { return false; }
  [[nodiscard]] std::size_t read_edges(std::span<LineEdge>) noexcept override { return 0; }
};

class Screen final : public testing::PlainDisplay {
 public:
  [[nodiscard]] Pixels width() const override { return Pixels{4}; }
  [[nodiscard]] Pixels height() const override { return Pixels{3}; }
  [[nodiscard]] Duration frame() const override { return 16ms; }
  void show(const Mask&, Presented) override {}
  void black(Presented) override {}
  void black_now() noexcept override {}
  [[nodiscard]] LightDisplayPath black_path() const override {
    return {.descriptor = kCard, .crtc = 1, .connector = 2, .black = 3, .mode = {}};
  }
};

std::unique_ptr<ZAxis> axis(Clock& clock, DescriptorWatcher& watcher, int breaking_step) {
  GpioAxisConfig config;
  config.homing_speed = MillimetersPerSecond{1000 / config.microsteps_per_mm};  // 1000 steps/s
  GpioAxis::Parts parts;
  parts.lines.step = std::make_unique<StepWire>(breaking_step);
  parts.lines.direction = std::make_unique<QuietWire>();
  parts.lines.inputs[static_cast<std::size_t>(AxisInput::LimitSwitch)] = std::make_unique<OpenSwitch>();
  parts.start_threads = [](StepEngine& engine, AxisInputs& inputs) {
    return std::make_unique<RealtimeAxisThreads>(engine, inputs, 1);
  };
  return std::make_unique<GpioAxis>(clock, watcher, config, std::move(parts));
}

// Runs in the child: turns light and motor on, then calls `err`, which breaks a contract.
void print_and(const std::function<void()>& err, int breaking_step) {
  VirtualClock clock;
  NoDescriptors watcher;
  FileDescriptor process;
  LightWatchdog watchdog = testing::ready_watchdog(clock, watcher, process);
  RealMachineConfig config;
  config.light = GpioLineConfig{.chip = "gpiochip0", .line = "24"};
  RealMachine machine(
      clock, watcher, watchdog, config,
      {.axis = [&] { return axis(clock, watcher, breaking_step); },
       .light = [&] { return std::make_unique<GpioLightLine>(std::make_unique<LightWire>(), "line", clock); },
       .display = [] { return std::make_unique<Screen>(); }});
  make_safe_on_broken_contract();
  machine.projector().light_on(1h, {.sent = [](TimePoint) {}, .done = [](ProjectorReply) {}});
  testing::watch_over_exposure(watchdog, process);
  expects(seen->light, "the light is on");
  machine.z_axis().home([](HomingResult) {});
  while (seen->steps < kStepsBefore)
    std::this_thread::yield();
  err();
}

struct End {
  std::string report;
  int status = 0;
};

End end_of(const std::function<void()>& err, int breaking_step = 0) {
  if (seen == nullptr) {
    void* const shared =
        ::mmap(nullptr, sizeof(Seen), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    REQUIRE(shared != MAP_FAILED);
    seen = static_cast<Seen*>(shared);
  }
  new (seen) Seen;
  int ends[2];
  REQUIRE(::pipe(ends) == 0);
  const pid_t child = ::fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    ::signal(SIGABRT, SIG_DFL);  // Catch2 would report the signal as this test's failure
    ::dup2(ends[1], STDERR_FILENO);
    print_and(err, breaking_step);
    ::_exit(0);
  }
  ::close(ends[1]);
  End end;
  end.report = testing::read_all(ends[0]);
  ::close(ends[0]);
  ::waitpid(child, &end.status, 0);
  return end;
}

void check_safe(const End& end, const std::string& requirement) {
  CHECK(WIFSIGNALED(end.status));
  CHECK(WTERMSIG(end.status) == SIGABRT);
  CHECK_FALSE(seen->light);
  CHECK(seen->lines_off >= 1);
  CHECK(seen->screens_black == 1);
  CHECK_FALSE(seen->light_when_black);
  CHECK(seen->steps >= kStepsBefore);
  // A step may have begun before.
  CHECK(seen->steps_past_black <= seen->steps_when_black + 1);
  CHECK(end.report.starts_with("contourd aborts because of a bug, light off sent, motor still: "));
  CHECK(end.report.ends_with(": " + requirement + "\n"));
  CHECK(std::ranges::count(end.report, '\n') == 1);
}

void break_a_contract() {
  (void)Mask(Pixels{4}, Pixels{3}).row(3);
}

}  // namespace

extern "C" int ioctl(int descriptor, unsigned long request, ...) noexcept {
  va_list arguments;
  va_start(arguments, request);
  void* const argument = va_arg(arguments, void*);
  va_end(arguments);
  if (descriptor == kLightLine) return set_line_off();
  if (descriptor == kCard) return set_screen_black();
  return static_cast<int>(syscall(SYS_ioctl, descriptor, request, argument));
}

TEST_CASE(
    "A contract broken during an exposure leaves light off, screen black, motor still and a line on stderr") {
  check_safe(end_of(break_a_contract), "the row is in the mask");
}

TEST_CASE("A contract broken by a thread other than the event loop's makes the machine safe, too") {
  check_safe(end_of([] { std::thread(break_a_contract).join(); }), "the row is in the mask");
}

TEST_CASE("A contract broken by the stepping thread makes the machine safe, and no further step follows") {
  const int breaking_step = kStepsBefore + 5;
  const auto wait = [] {
    for (;;)
      ::pause();
  };
  check_safe(end_of(wait, breaking_step), "the stepping thread makes no mistake");
  CHECK(seen->steps == breaking_step);
}

TEST_CASE("A broken contract is not reported if no one reads stderr, and the process aborts all the same") {
  const End end = end_of([] {
    int full[2];
    if (::pipe2(full, O_NONBLOCK) != 0) return;
    char bytes[4096] = {};
    while (::write(full[1], bytes, sizeof bytes) > 0) {
    }
    ::dup2(full[1], STDERR_FILENO);
    break_a_contract();
  });
  CHECK(end.report.empty());
  CHECK(WIFSIGNALED(end.status));
  CHECK_FALSE(seen->light);
}
