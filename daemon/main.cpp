// contourd: wires the machine, the printer service and the event loop, and nothing else.
#include <fmt/format.h>
#include <signal.h>

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <memory>

#include "daemon/config/printer_config.hpp"
#include "daemon/control_defaults.hpp"
#include "daemon/event_loop.hpp"
#include "daemon/log.hpp"
#include "daemon/printer_service.hpp"
#include "daemon/supervisor.hpp"
#include "hw/simulated_printer.hpp"
#include "hw/virtual_clock.hpp"

namespace contourd {
namespace {

// Exit codes of BSD's sysexits.h; systemd does not restart after 78 (see contourd.service).
constexpr int kBadUsage = 64, kFailed = 70, kBadConfig = 78;

// The clock of the machine: the monotonic one, or for the simulated printer one that skips all waiting.
class MachineClock {
 public:
  MachineClock(EventLoop& loop, Pace pace) {
    if (pace == Pace::Realtime) {
      clock_ = std::make_unique<EventLoopClock>(loop);
      return;
    }
    auto fast = std::make_unique<VirtualClock>();
    VirtualClock* const clock = fast.get();
    idle_ = loop.when_idle([clock] { return clock->run_next(); });
    clock->on_work([this] { idle_->wake(); });
    clock_ = std::move(fast);
  }

  [[nodiscard]] Clock& get() { return *clock_; }

 private:
  std::unique_ptr<EventLoop::IdleSource> idle_;
  std::unique_ptr<Clock> clock_;
};

int run(const PrinterConfig& config) {
  EventLoop loop;
  // Before any thread is made: signals come through the loop alone. SIGIO would come from a lease (see
  // spool.cpp).
  ::signal(SIGPIPE, SIG_IGN);
  ::signal(SIGIO, SIG_IGN);
  Supervisor supervisor(loop);
  PrinterService* running = nullptr;
  const auto stop = [&](const char* signal) {
    supervisor.stopping();
    if (running != nullptr) running->shut_down(fmt::format("contourd was stopped ({})", signal));
  };
  const auto terminated = loop.on_signal(SIGTERM, [&] { stop("SIGTERM"); });
  const auto interrupted = loop.on_signal(SIGINT, [&] { stop("SIGINT"); });
  const auto hung_up = loop.on_signal(SIGHUP, [&] { stop("SIGHUP"); });

  const Log log;
  MachineClock clock(loop, config.pace);
  SimulatedPrinter machine(clock.get(), config.simulated);
  PrinterService service(config, loop, clock.get(), machine, log, supervisor);
  running = &service;
  service.start();
  log.info("ready", fmt::format("contourd {} is ready: {}, spool {}, socket {}", CONTOURD_VERSION,
                                config.name, config.spool_folder.string(), config.control_socket.string()));
  supervisor.ready();
  loop.run();
  log.info("stopped", "contourd has stopped; light off, motor still");
  return EXIT_SUCCESS;
}

int start(int argc, char** argv) {
  CLI::App app{"Makes a resin printer of a computer, a projector and a Z stage."};
  app.set_version_flag("--version", CONTOURD_VERSION);
  std::string config_file = kDefaultConfig, checked_file, pace;
  bool print_states = false;
  app.add_option("--config", config_file, "Printer configuration")->capture_default_str();
  const CLI::Option* check =
      app.add_option("--check-config", checked_file, "Say what is wrong with a configuration, and exit");
  app.add_option("--pace", pace, "Overrides the configuration's simulation.pace")
      ->check(CLI::IsMember({"realtime", "fast"}));
  app.add_flag("--print-states", print_states, "Print the print process as a Graphviz graph, and exit");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? EXIT_SUCCESS : kBadUsage;
  }
  if (print_states) {
    fmt::print("{}", draw_print_states());
    return EXIT_SUCCESS;
  }
  if (check->count() > 0) {
    const PrinterConfig config = load_printer_config(checked_file);
    fmt::print("{}: good\n", checked_file);
    return EXIT_SUCCESS;
  }
  PrinterConfig config = load_printer_config(config_file);
  if (!pace.empty()) config.pace = pace == "fast" ? Pace::Fast : Pace::Realtime;
  return run(config);
}

}  // namespace
}  // namespace contourd

int main(int argc, char** argv) {
  try {
    return contourd::start(argc, argv);
  } catch (const contourd::ConfigError& error) {
    fmt::print(stderr, "{}\n", error.what());
    return contourd::kBadConfig;
  } catch (const std::exception& error) {
    fmt::print(stderr, "contourd: {}\n", error.what());
    return contourd::kFailed;
  }
}
