// The pictures on which the lamp's light is measured over the display, shown by manual control.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/calibration/lamp_pictures.hpp"
#include "daemon/client/control_defaults.hpp"
#include "daemon/config/printer_config.hpp"
#include "daemon/ctl/calibration/calibration_commands.hpp"
#include "daemon/ctl/calibration/lamp_readings.hpp"
#include "daemon/ctl/calibration/light_by_hand.hpp"
#include "daemon/ctl/terminal/dialog.hpp"
#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/system/readable.hpp"

namespace contourd::ctl {
namespace {

constexpr double kFieldSeconds = 10;
constexpr double kLargestReading = 1e9;
constexpr std::size_t kStepIndent = 3;  // after the number of a step

struct LampArgs {
  std::filesystem::path printer = kDefaultConfig;
  std::string grid = "5x3";
  bool photo = false, confirm = false, in_resin = false;
  std::optional<double> seconds;
};

// Shows the pictures, without uniformity mask and gamma.
class LampPrint {
 public:
  LampPrint(const ClientOptions& client, const LampArgs& args)
      : client_(client),
        args_(args),
        printer_(load_printer_config(args.printer, Places::Elsewhere)),
        grid_(parse_lamp_grid(args.grid)) {
    seconds_ = args.seconds.value_or(args.photo ? longest_s() : std::min(kFieldSeconds, longest_s()));
    if (!(seconds_ > 0) || seconds_ > longest_s())
      throw UsageError(
          fmt::format("--seconds {:.4g}: manual.light_limit_s allows more than 0 and at most {:g} s",
                      seconds_, longest_s()));
  }

  int run() {
    try {
      if (const int code = prepare(); code != kOk) return code;
      return args_.photo ? show_photo() : show_fields();
    } catch (const DialogLeft&) {
      fmt::print("\nThe light is off.\n");
      return kFailed;
    }
  }

 private:
  [[nodiscard]] double longest_s() const {
    return std::chrono::duration<double>(printer_.manual.light_limit).count();
  }
  [[nodiscard]] bool asks() const { return !args_.confirm; }
  [[nodiscard]] double mm(double place, Pixels side) const {
    return (place + 1) / 2 * side.count() * printer_.pixel_pitch.count() / 1000;
  }

  int prepare() {
    if (asks()) {
      dialog_.say("q quits at any question; Ctrl-C also turns the light off.");
      dialog_.say("1. Take the build plate off, and the vat, or put a clean and empty vat in.", kStepIndent);
      dialog_.say(args_.photo
                      ? "2. Lay a sheet of matt white paper on the film. Put a camera straight above it, far "
                        "away, with the picture in the middle third of the photo."
                      : "2. Hold the meter's sensor on the film, always in the same way. Places are given "
                        "from the picture's upper left corner, as the projector gets it.",
                  kStepIndent);
      (void)dialog_.ask("UV light will shine. Eyes protected? Press Enter to begin.");
    }
    if (printer_.uniformity) fmt::print("The pictures are shown without the printer's uniformity mask.\n");
    return warm_up(client_);
  }

  int show_fields() {
    std::string readings;
    for (int cell = 0; cell < grid_.cells(); ++cell) {
      const LampPlace middle =
          lamp_field(grid_, cell, printer_.display_width, printer_.display_height).middle;
      const std::string field =
          fmt::format("field {} of {}, column {}, row {}: {:.4g} mm to the right, {:.4g} mm down", cell + 1,
                      grid_.cells(), cell % grid_.columns + 1, cell / grid_.columns + 1,
                      mm(middle.x, printer_.display_width), mm(middle.y, printer_.display_height));
      if (asks())
        (void)dialog_.ask(fmt::format("{}. Enter lights it for {:.3g} s.", field, seconds_));
      else
        fmt::print("{}: {:.3g} s\n", field, seconds_);
      std::fflush(stdout);
      const Mask picture = draw_lamp_field(grid_, cell, printer_.display_width, printer_.display_height);
      if (const int code = shine(client_, picture, {seconds_, args_.in_resin}); code != kOk) return code;
      readings += fmt::format(" {}", asks() ? ask_reading() : kNotMeasured);
    }
    fmt::print("\n");
    const Dialog dialog;
    dialog.say(
        "Then type the readings instead of the question marks; leave those of fields that were not "
        "measured:");
    fmt::print("\ncontourctl fit lamp --printer {} --grid {}{}\n", printable(args_.printer.string()),
               printable(args_.grid), readings);
    return kOk;
  }

  std::string ask_reading() {
    const std::optional<double> reading =
        dialog_.ask_for_number("The reading; Enter if it was not measured:", 0, kLargestReading);
    return reading ? fmt::format("{}", *reading) : kNotMeasured;
  }

  int show_photo() {
    fmt::print("white picture: {:.3g} s\n", seconds_);
    std::fflush(stdout);
    const Mask picture = draw_lamp_photo(printer_.display_width, printer_.display_height);
    if (const int code = shine(client_, picture, {seconds_, args_.in_resin}); code != kOk) return code;
    fmt::print("\n");
    const Dialog dialog;
    dialog.say(
        "Use a raw photo that is not overexposed, converted into a PNG file of 16 bits in proportion to "
        "the "
        "light (--encoding linear). A JPEG file, converted into PNG, has its camera's own curve, which "
        "--encoding "
        "srgb approximates. Find the picture's corners in the photo, in pixels: first that with one dot, "
        "then "
        "those with two, three and four. Type them instead of the question marks:");
    fmt::print(
        "\ncontourctl fit lamp --printer {} --photo PHOTO.png --encoding linear --corners ?,?,?,?,?,?,?,?\n",
        printable(args_.printer.string()));
    return kOk;
  }

  const ClientOptions& client_;
  const LampArgs& args_;
  PrinterConfig printer_;
  LampGrid grid_;
  double seconds_ = 0;
  Dialog dialog_;
};

}  // namespace

void add_calibrate_lamp(Command& calibrate) {
  Command& command = calibrate.add(
      "lamp", "Show fields of light over the display, for a meter or a photo, for the uniformity mask");
  auto& args = command.arguments<LampArgs>();
  const Option& grid = command.option("--grid", args.grid, "Columns and rows of fields, as in 5x3");
  command.option("--photo", args.photo, "Show a white picture with dots in its corners instead")
      .excludes(grid);
  command.option("--printer", args.printer, "Configuration of the printer");
  command.option("--seconds", args.seconds,
                 "Light on each picture, s (default: 10; for a photo, manual.light_limit_s)");
  command.option("--confirm", args.confirm,
                 "Confirm that eyes are protected, and show all pictures without asking");
  command.option("--in-resin", args.in_resin, "Allow light while the plate may be in the resin");
  const ClientOptions& client = add_socket_option(command);
  command.run = [&client, &args] { return LampPrint(client, args).run(); };
}

}  // namespace contourd::ctl
