#include "daemon/ctl/commands/commands.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <system_error>
#include <utility>

#include "daemon/client/control_defaults.hpp"
#include "daemon/client/daemon_connection.hpp"
#include "daemon/config/config_edit.hpp"
#include "daemon/config/printer_config.hpp"
#include "daemon/ctl/commands/manual_command.hpp"
#include "daemon/ctl/terminal/client.hpp"
#include "daemon/ctl/terminal/dialog.hpp"
#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/system/readable.hpp"

namespace contourd::ctl {
namespace {

using Json = DaemonConnection::Json;

constexpr double kClearance_mm = 20;  // room for hands between plate and film
constexpr std::size_t kIndent = 3;    // after the number of a step
constexpr double kMostPaper_mm = 5, kMostGap_mm = 20;
// Tolerance when heights of the configuration and the daemon are compared; a motor step is smaller.
constexpr double kSame_mm = 0.02;

class Level {
 public:
  Level(const ClientOptions& client, std::filesystem::path config)
      : client_(client), file_(std::move(config)), config_(load_printer_config(file_)) {}

  int run() {
    if (::access(std::filesystem::canonical(file_).parent_path().c_str(), W_OK) != 0)
      throw std::system_error(errno, std::generic_category(),
                              "cannot write into the folder of " + file_.string());
    try {
      if (const int code = prepare(); code != kOk) return code;
      if (const int code = press_flat(); code != kOk) return code;
      return store(measure());
    } catch (const DialogLeft&) {
      fmt::print("\nNothing was changed.\n");
      return kFailed;
    }
  }

 private:
  int send(const char* method, const Json& parameters) {
    return control_by_hand(client_, {method, parameters}, WaitFor::Operation);
  }
  int move_to(double height_mm) { return send("move", {{"to_mm", height_mm}, {"plate_is_clear", true}}); }
  [[nodiscard]] double height() const {
    DaemonConnection connection(client_.socket);
    const Json reply = connection.ask({"status"});
    const Json& height = reply["result"]["manual"]["height_mm"];
    return height.is_number() ? height.get<double>() : NAN;
  }

  int prepare() {
    dialog_.say("q quits at any question; Ctrl-C also stops the plate.");
    dialog_.say("1. Put the empty, clean vat in its place. Nothing may be on the plate or in its way.",
                kIndent);
    (void)dialog_.ask("Press Enter to home the plate.");
    if (const int code = send("home", {{"plate_is_clear", true}}); code != kOk) return code;
    switch_height_ = height();
    if (!(std::abs(switch_height_ - configured()) <= kSame_mm)) {
      fmt::print(
          stderr,
          "contourctl: contourd uses a switch height of {:.3f} mm, but {} has {:.3f} mm: contourd runs with "
          "another or an older configuration; run sudo systemctl reload contourd first\n",
          switch_height_, printable(file_.string()), configured());
      return kFailed;
    }
    return move_to(std::min(kClearance_mm, travel()));
  }
  [[nodiscard]] double travel() const { return to_millimeters(config_.travel).count(); }
  [[nodiscard]] double configured() const {
    return config_.real ? to_millimeters(config_.real->axis.switch_height).count() : 0;
  }

  int press_flat() {
    dialog_.say(
        "2. Loosen the plate's clamp, so that the plate swings freely, and lay a sheet of paper on the film.",
        kIndent);
    (void)dialog_.ask("Press Enter to move the plate down to 0 mm.");
    if (const int code = move_to(0); code != kOk) return code;
    dialog_.say("3. Press the plate flat onto the paper, and tighten the clamp.", kIndent);
    (void)dialog_.ask("Press Enter when the clamp is tight.");
    return kOk;
  }

  // Returns how much higher the plate is than contourd's height, mm.
  double measure() {
    dialog_.say(
        "4. Find the height at which the paper just drags when it is pulled: enter distances in mm to move "
        "the plate, negative for down.",
        kIndent);
    const double most = travel();
    while (true) {
      const double distance =
          dialog_
              .ask_for_number(
                  fmt::format("Now at {:.3f} mm. Move by (Enter: the paper just drags)?", height()), -most,
                  most)
              .value_or(0);
      if (distance == 0) break;
      (void)send("move", {{"by_mm", distance}, {"plate_is_clear", true}});  // send() prints a failure
    }
    const double drags_at = height();
    double gap = 0;
    if (drags_at < kSame_mm) {
      const char* const question = "How far is the plate above the paper at 0 mm, mm (Enter: it touches)?";
      gap = dialog_.ask_for_number(question, 0, kMostGap_mm).value_or(0);
    }
    const auto paper = dialog_.ask_for_number("How thick is the paper, mm (Enter: 0.1)?", 0, kMostPaper_mm);
    return paper.value_or(0.1) + gap - drags_at;
  }

  int store(double off) {
    const double height = std::round((configured() + off) * 1000) / 1000;
    dialog_.say(
        fmt::format(
            "5. z_axis.switch_height_mm changes from {:g} to {:g}: the plate is {:g} mm {} than reported.",
            configured(), height, std::abs(off), off < 0 ? "lower" : "higher"),
        kIndent);
    (void)dialog_.ask(fmt::format("Press Enter to write it to {}.", file_.string()));
    set_config_number(file_, "z_axis", "switch_height_mm", height);
    if (const int code = move_to(std::min(kClearance_mm, travel())); code != kOk) return code;
    dialog_.say("Written. Apply it with: sudo systemctl reload contourd; then the plate homes again.");
    return kOk;
  }

  const ClientOptions& client_;
  std::filesystem::path file_;
  PrinterConfig config_;
  double switch_height_ = 0;
  Dialog dialog_;
};

}  // namespace

void add_level(Command& program) {
  Command& command =
      program.add("level", "Level the plate, step by step, and store the limit switch's height");
  auto& config = command.arguments<std::filesystem::path>();
  config = kDefaultConfig;
  command.option("--config", config, "Configuration of the printer");
  const ClientOptions& client = add_socket_option(command);
  command.run = [&client, &config] { return Level(client, config).run(); };
}

}  // namespace contourd::ctl
