// The objects that the components of the printer share, for their tests: a spool in a folder of its own, a
// simulated machine whose time runs as fast as it can, and the log as text. Not thread-safe.
#pragma once

#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <sstream>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "daemon/config/printer_config.hpp"
#include "daemon/jobs/printer_context.hpp"
#include "daemon/spool/spool.hpp"
#include "hw/simulated_printer.hpp"
#include "hw/virtual_clock.hpp"
#include "tests/models/models.hpp"
#include "tests/temporary_folder.hpp"
#include "tests/time_limit.hpp"

namespace contourd::testing {

// Returns the shipped simulated printer, without saved masks, free disk space or supports.
inline PrinterConfig simulated_config(const std::filesystem::path& folder) {
  PrinterConfig config = load_printer_config(std::filesystem::path(CONTOURD_CONFIG_DIR) / "simulated.json");
  config.spool_folder = folder / "spool";
  config.control_socket = folder / "control.sock";
  config.min_free_disk_bytes = 0;
  config.simulated.display.masks.reset();
  config.supports = SupportPolicy::Off;
  return config;
}

// Log entries as lines: "warning: ...".
class LogText {
 public:
  explicit LogText(EventLoop& loop) : log(loop) {
    auto logger =
        std::make_shared<spdlog::logger>("test", std::make_shared<spdlog::sinks::ostream_sink_st>(text_));
    logger->set_pattern("%l: %v");
    spdlog::set_default_logger(std::move(logger));
  }

  [[nodiscard]] bool has(std::string_view what) const { return text_.str().find(what) != std::string::npos; }
  [[nodiscard]] int count(std::string_view what) const {
    const std::string text = text_.str();
    int found = 0;
    for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1))
      ++found;
    return found;
  }

 private:
  std::ostringstream text_;

 public:
  Log log;
};

class NoSpoolObserver : public SpoolObserver {
  void model_arrived(const std::string&) override {}
  void model_withdrawn(const std::string&) override {}
  void plate_waits(const std::string&, const std::vector<std::string>&) override {}
  void ignored(const std::string&, WhyIgnored) override {}
  void more_ignored(std::size_t) override {}
  void incoming_lost(const std::string&) override {}
  void incoming_replaced() override {}
};

// Runs the loop until `so` returns true; returns false after kTimeLimit. To be called once for a loop,
// because an event loop does not run again.
inline bool run_loop_until(EventLoop& loop, const std::function<bool()>& so) {
  bool reached = false;
  const auto given_up =
      loop.at(std::chrono::steady_clock::now() + kTimeLimit, "the test", [&loop] { loop.stop(); });
  const auto looks = loop.when_idle("the test", [&] {
    reached = so();
    if (reached) loop.stop();
    std::this_thread::yield();  // leaves the processor to the thread that is waited for
    return !reached;
  });
  loop.run();
  return reached;
}

class PrinterFixture {
 public:
  // Puts a model 0.2 mm high into a folder of the spool.
  void put(Spool::Folder where, const std::string& file) const {
    models::write_binary_stl(spool.folder(where) / file, models::box({0, 0, 0}, {3, 2, 0.2F}));
  }
  void put_text(Spool::Folder where, const std::string& file, std::string_view text) const {
    std::ofstream(spool.folder(where) / file) << text;
  }
  // True if the spool folder has this path.
  [[nodiscard]] bool has(const std::string& path) const {
    return std::filesystem::exists(config.spool_folder / path);
  }
  [[nodiscard]] bool has_record(const std::string& name) const {
    return std::filesystem::exists(state() / name);
  }
  [[nodiscard]] std::filesystem::path state() const { return folder.path() / "spool.state"; }

  // Runs the loop, and the machine's time with it, until `so` returns true, as run_loop_until() does.
  bool run_until(const std::function<bool()>& so) {
    return run_loop_until(loop, [&] {
      const bool reached = so();
      (void)clock.run_next();
      return reached;
    });
  }

  // Calls each step after the spool's thread has done what the last one wanted of it. To be called once, as
  // run_until(); returns false if that takes longer than kTimeLimit.
  bool run_steps(const std::function<bool()>& saving, const std::vector<std::function<void()>>& steps) {
    std::size_t next = 0;
    return run_until([&] {
      if (saving()) return false;
      if (next == steps.size()) return true;
      steps[next++]();
      return false;
    });
  }

  TemporaryFolder folder;
  PrinterConfig config = simulated_config(folder.path());
  EventLoop loop;
  VirtualClock clock;
  LogText log{loop};
  Supervisor supervisor{loop};
  SimulatedPrinter machine{clock, config.simulated};
  PrinterContext context{config, loop, clock, machine, log.log, supervisor};
  NoSpoolObserver observer;
  Spool spool{config.spool_folder, loop, observer};
};

}  // namespace contourd::testing
