#include "daemon/app/start_program.hpp"

#include <fmt/format.h>
#include <malloc.h>
#include <signal.h>

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include "daemon/app/broken_contract.hpp"
#include "daemon/app/light_record.hpp"
#include "daemon/app/login_bus.hpp"
#include "daemon/app/printer_service.hpp"
#include "daemon/app/sleep_inhibitor.hpp"
#include "daemon/check/config_check.hpp"
#include "daemon/client/control_defaults.hpp"
#include "daemon/config/light_config.hpp"
#include "daemon/config/printer_config.hpp"
#include "daemon/print/print_modes.hpp"
#include "daemon/system/command_line.hpp"
#include "daemon/system/durable_file.hpp"
#include "daemon/system/event_loop.hpp"
#include "daemon/system/log.hpp"
#include "daemon/system/readable.hpp"
#include "daemon/system/standard_output.hpp"
#include "daemon/system/supervisor.hpp"
#include "hw/hardware_check.hpp"
#include "hw/light_off.hpp"
#include "hw/real_machine.hpp"
#include "hw/simulated_printer.hpp"
#include "hw/virtual_clock.hpp"
#include "hw/watchdog/light_watchdog_process.hpp"

namespace contourd {
namespace {

// The clock of the machine: the monotonic clock, or, for a simulated printer at a fast pace, a clock that
// skips all waiting.
class MachineClock {
 public:
  MachineClock(EventLoop& loop, Pace pace) {
    if (pace == Pace::Realtime) {
      clock_ = std::make_unique<EventLoopClock>(loop);
      return;
    }
    auto fast = std::make_unique<VirtualClock>();
    VirtualClock* const clock = fast.get();
    idle_ = loop.when_idle("the simulated clock", [clock] { return clock->run_next(); });
    clock->on_work([this] { idle_->wake(); });
    clock_ = std::move(fast);
  }

  [[nodiscard]] Clock& get() { return *clock_; }

 private:
  std::unique_ptr<EventLoop::IdleSource> idle_;
  std::unique_ptr<Clock> clock_;
};

// The machine, simulated or real. A real one has a light watchdog, a process that turns the light off if this
// process does not.
class PrinterMachine {
 public:
  PrinterMachine(const PrinterConfig& config, Clock& clock, DescriptorWatcher& watcher, const Log& log) {
    if (!config.real) {
      machine_ = std::make_unique<SimulatedPrinter>(clock, config.simulated);
      return;
    }
    watchdog_.emplace(clock, watcher, start_light_watchdog);
    auto machine = std::make_unique<RealMachine>(clock, watcher, *watchdog_, *config.real);
    for (const std::string& device : machine->description())
      log.info("machine", printable(device));
    for (const std::string& warning : machine->warnings())
      log.warning("machine", printable(warning));
    machine_ = std::move(machine);
  }

  [[nodiscard]] Machine& get() { return *machine_; }

 private:
  std::optional<LightWatchdog> watchdog_;
  std::unique_ptr<Machine> machine_;
};

// Keeps the computer awake while a real machine prints.
class PrintWake final : private SleepingPrint {
 public:
  PrintWake(EventLoop& loop, Clock& clock, Machine& machine, PrinterService& service, const Log& log)
      : machine_(machine), service_(service), log_(log), login_(loop), inhibitor_(login_, clock, *this) {
    service.on_printing([this](bool prints) { inhibitor_.hold(prints); });
  }

 private:
  void interrupt() override {
    service_.handle_event(
        {.kind = MachineEvent::Kind::Interlock, .what = "the computer is about to be suspended"});
  }
  [[nodiscard]] bool dark() const override { return machine_.projector().light_off_unconfirmed().empty(); }
  void unguarded(const std::string& why) override {
    log_.info("machine", fmt::format("the computer may be suspended during a print: {}", printable(why)));
  }

  Machine& machine_;
  PrinterService& service_;
  const Log& log_;
  LoginBus login_;
  SleepInhibitor inhibitor_;
};

// Checks every device, even if others are bad, prints one line for each, and returns the exit code.
int check_hardware(const PrinterConfig& config) {
  if (!config.real) {
    fmt::print("{}: the hardware is simulated, there is nothing to check\n", printable(config.name));
    return EXIT_SUCCESS;
  }
  EventLoop loop;
  EventLoopClock clock(loop);
  EventLoopWatcher watcher(loop);
  HardwareCheck check(clock, watcher, *config.real);
  int problems = 0;
  check.run(
      [&](const HardwareFinding& finding) {
        if (!finding.good) ++problems;
        const char* verdict = !finding.good ? "BAD" : finding.warning ? "warn" : "ok";
        fmt::print("{:4} {:15} {}\n", verdict, printable(finding.device), printable(finding.what));
      },
      [&] { loop.stop(); });
  loop.run();
  if (problems == 0) return EXIT_SUCCESS;
  fmt::print("{}\n", problems == 1 ? "1 problem prevents printing"
                                   : fmt::format("{} problems prevent printing", problems));
  return kMissingDevice;
}

void warn_light_may_be_on(const std::string& why) {
  fmt::print(stderr, "the light may be on: {}\n", printable(why));
}

// Returns the recorded light; nullopt if there is no record, or if it cannot be read (reported on stderr).
std::optional<LightConfig> recorded_light(const std::filesystem::path& record) {
  std::error_code error;
  if (!std::filesystem::exists(record, error)) return std::nullopt;
  try {
    return read_light_record(record);
  } catch (const ConfigError& unreadable) {
    fmt::print(stderr, "{}\n", unreadable.what());
    return std::nullopt;
  }
}

// Turns the light off as recorded by the last daemon, or else as configured, as far as the configuration can
// be read. Returns the exit code.
int light_off(const std::string& config_file) {
  FoundLight found = find_light(config_file);
  const std::filesystem::path record = light_record_path(found.control_socket.value_or(kDefaultSocket));
  const std::optional<LightConfig> recorded = recorded_light(record);
  if (recorded) found = {.light = *recorded, .control_socket = {}, .problems = {}, .elsewhere = {}};
  for (const Violation& violation : found.elsewhere)
    fmt::print(stderr, "{}\n", ConfigError({violation}).what());
  for (const Violation& violation : found.problems)
    warn_light_may_be_on(ConfigError({violation}).what());

  EventLoop loop;
  EventLoopClock clock(loop);
  EventLoopWatcher watcher(loop);
  LightOff light(clock, watcher, found.light);
  std::vector<std::string> problems;
  light.run([&](const std::vector<std::string>& what) {
    problems = what;
    loop.stop();
  });
  loop.run();
  for (const std::string& problem : problems)
    warn_light_may_be_on(problem);
  if (!found.problems.empty()) return kBadConfig;
  std::error_code ignored;
  if (problems.empty()) {
    std::filesystem::remove(record, ignored);
    return EXIT_SUCCESS;
  }
  if (recorded)
    fmt::print(stderr, "the light is as described in {}, which the last contourd left\n",
               printable(record.string()));
  return kMissingDevice;
}

// Stores the light's record for `contourd --light-off`, if the machine is real; logs why it cannot.
void leave_light_record(const PrinterConfig& config, const std::string& record, const Log& log) {
  if (!config.real) return;
  try {
    write_durably(light_record_path(config.control_socket), record);
  } catch (const std::system_error& error) {
    log.warning("machine",
                fmt::format("{}: if contourd crashes, --light-off uses the configuration as it is then",
                            printable(error.what())));
  }
}

int run(const PrinterConfig& config) {
  // Larger blocks are returned to the system when they are freed, so that the memory of one model's facets is
  // available to the next.
  constexpr int kMmapThreshold = 1 << 20;
  ::mallopt(M_MMAP_THRESHOLD, kMmapThreshold);
  EventLoop loop;
  // Must precede the first thread: only the loop receives signals. A file lease would send SIGIO (see
  // upload_state.cpp).
  ::signal(SIGPIPE, SIG_IGN);
  ::signal(SIGIO, SIG_IGN);
  Supervisor supervisor(loop);
  PrinterService* running = nullptr;
  int ended = EXIT_SUCCESS;
  const auto stop = [&](const char* signal) {
    ended = EXIT_SUCCESS;
    supervisor.stopping();
    if (running != nullptr)
      std::exchange(running, nullptr)->shut_down(fmt::format("contourd was stopped ({})", signal));
  };
  const auto terminated = loop.on_signal(SIGTERM, [&] { stop("SIGTERM"); });
  const auto interrupted = loop.on_signal(SIGINT, [&] { stop("SIGINT"); });
  const auto hung_up = loop.on_signal(SIGHUP, [&] { stop("SIGHUP"); });
  const auto reloaded = loop.on_signal(SIGUSR1, [&] {
    if (running == nullptr) return;  // already stopping
    ended = kRestart;
    running->hand_over_when_idle();
  });

  const Log log(loop);
  MachineClock clock(loop, config.pace);
  EventLoopWatcher watcher(loop);
  PrinterMachine printer(config, clock.get(), watcher, log);
  Machine& machine = printer.get();
  PrinterService service(config, loop, clock.get(), machine, log, supervisor);
  running = &service;
  std::optional<PrintWake> wake;
  if (config.real) wake.emplace(loop, clock.get(), machine, service, log);
  service.start();
  leave_light_record(config, config.light_record, log);  // no light before the loop runs
  log.info("ready", fmt::format("contourd {} is ready: {}, spool {}, socket {}", CONTOURD_VERSION,
                                printable(config.name), printable(config.spool_folder.string()),
                                printable(config.control_socket.string())));
  supervisor.ready();
  loop.run();
  const std::string unconfirmed = machine.projector().light_off_unconfirmed();
  if (!unconfirmed.empty()) {
    log.warning("stopped", fmt::format("contourd has stopped; motor still, light off sent, but {}",
                                       printable(unconfirmed)));
    return ended;
  }
  log.info("stopped", "contourd has stopped; light off, motor still");
  if (config.real) leave_light_record(config, left_dark(config.light_record), log);
  return ended;
}

}  // namespace

int start_program(int argc, char** argv) {
  make_safe_on_broken_contract();
  CLI::App app{"Turns a computer, a projector and a Z stage into a resin printer."};
  app.set_version_flag("--version", CONTOURD_VERSION);
  std::string config_file = kDefaultConfig, checked_file, pace;
  bool print_states = false, look_at_hardware = false, only_light_off = false;
  app.add_option("--config", config_file, "Printer configuration")->capture_default_str();
  CLI::Option* const check =
      app.add_option("--check-config", checked_file, "Check a configuration, report its errors, and exit");
  CLI::Option* const look = app.add_flag("--check-hardware", look_at_hardware,
                                         "Check the configured devices without motion or light, and exit");
  CLI::Option* const dark = app.add_flag(
      "--light-off", only_light_off, "Turn off a light that a crashed contourd may have left on, and exit");
  app.add_option("--pace", pace, "Override simulation.pace of the configuration")
      ->check(CLI::IsMember({"realtime", "fast"}));
  CLI::Option* const draw =
      app.add_flag("--print-states", print_states, "Print all state machines as a Graphviz graph, and exit");
  check->excludes(look, dark, draw);
  look->excludes(dark, draw);
  dark->excludes(draw);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return end_of_command_line(app, error);
  }
  if (print_states) {
    fmt::print("{}", draw_print_states());
    return EXIT_SUCCESS;
  }
  if (check->count() > 0) {
    check_config(checked_file);
    return EXIT_SUCCESS;
  }
  if (only_light_off) return light_off(config_file);
  PrinterConfig config = load_printer_config(config_file);
  if (look_at_hardware) return check_hardware(config);
  if (!pace.empty() && config.real) {
    fmt::print(stderr, "--pace is for the simulated printer; the hardware of {} is real\n",
               printable(config_file));
    return kBadUsage;
  }
  if (!pace.empty()) config.pace = pace == "fast" ? Pace::Fast : Pace::Realtime;
  return run(config);
}

}  // namespace contourd
