#include "daemon/ctl/commands/manual_command.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "core/image/test_pattern.hpp"
#include "daemon/client/control_defaults.hpp"
#include "daemon/client/daemon_connection.hpp"
#include "daemon/config/printer_config.hpp"
#include "daemon/ctl/commands/commands.hpp"
#include "daemon/ctl/models/model_arguments.hpp"
#include "daemon/ctl/models/read_model.hpp"
#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/formats/model_names.hpp"
#include "daemon/system/base64.hpp"
#include "daemon/system/readable.hpp"
#include "hw/png_file.hpp"

namespace contourd::ctl {
namespace {

// Arguments of all commands for manual control.
struct ManualArgs {
  std::optional<double> to_mm, by_mm, speed_mm_s, seconds;
  bool plate_is_clear = false, in_resin = false, confirm = false, unhomed = false;
};

struct ShowOptions {
  std::string what;  // a pattern's name, a PNG file, or with `at_z_mm` a model's file
  std::optional<double> seconds;
  std::optional<double> at_z_mm;                   // height above the plate of the mask to show
  std::filesystem::path printer = kDefaultConfig;  // configuration for that mask
  std::optional<std::filesystem::path> ticket;
};

using Json = DaemonConnection::Json;

// Replaces the names of parameters in contourd's refusal by the names of contourctl's options.
std::string with_options(std::string sentence) {
  for (const auto& [parameter, option] :
       {std::pair("plate_is_clear", "--plate-is-clear"), std::pair("in_resin", "--in-resin"),
        std::pair("to_mm", "--to"), std::pair("by_mm", "--by"), std::pair("speed_mm_s", "--speed"),
        std::pair("seconds must", "--seconds must"), std::pair("pattern must", "PATTERN must")}) {
    if (const std::size_t at = sentence.find(parameter); at != std::string::npos)
      sentence.replace(at, std::string_view(parameter).size(), option);
  }
  return sentence;
}

enum Question { kWatch = 1, kRequest, kUpload };

// Prints the part of the status that concerns manual control.
void print_manual(const Json& status) {
  const Json& manual = status["manual"];
  if (manual["height_mm"].is_number())
    fmt::print("height    {:.3f} mm\n", manual["height_mm"].get<double>());
  else
    fmt::print("height    unknown\n");
  if (manual.value("homing_shift_um", Json()).is_number())
    fmt::print("switch    {}\n", describe_homing_shift(manual["homing_shift_um"].get<double>()));
  if (const std::string picture = text_of(manual, "picture"); !picture.empty())
    fmt::print("picture   {}\n", picture);
  if (!manual["projector"].is_object()) return;
  const Json& projector = manual["projector"];
  const auto& powered = projector["powered"];
  fmt::print("projector {}\n", !powered.is_boolean() ? "cannot be asked"
                               : powered.get<bool>() ? "on"
                                                     : "off");
  if (projector["lamp_hours"].is_number())
    fmt::print("lamp      {} h\n", projector["lamp_hours"].get<std::int64_t>());
}

// The progress of one request, followed message by message.
class Operation {
 public:
  Operation(WaitFor what, bool json, Progress progress)
      : what_(what), json_(json), silent_(json || progress == Progress::Hidden) {}

  // Handles a message. Returns the exit code once the operation has ended.
  std::optional<int> take(const Json& message) {
    if (json_) print_json(message);
    const bool reply = message.value("id", 0) == kRequest;
    if (reply && message.contains("error")) {
      if (!json_)
        fmt::print(stderr, "contourctl: {}\n",
                   printable_lines(with_options(message["error"].value("message", ""))));
      return kFailed;
    }
    if (message.contains("params")) last_ = message["params"];
    if (reply) {
      begun_ = true;
      // A notification that came before the reply may be newer than the reply.
      const Json& result = message["result"];
      if (!last_.is_object() || operations(last_) <= operations(result)) last_ = result;
    }
    if (!last_.is_object() || !last_.contains("manual")) return std::nullopt;
    print_phase();
    return begun_ && is_over() ? std::optional(end()) : std::nullopt;
  }

 private:
  static std::uint64_t operations(const Json& status) {
    return status["manual"].value("operations", std::uint64_t{0});
  }
  [[nodiscard]] bool is_over() const {
    const Json& manual = last_["manual"];
    return what_ == WaitFor::Picture ? manual["picture"].is_null() : manual.value("state", "") == "idle";
  }
  void print_phase() {
    const std::string now = phase();
    if (silent_ || now.empty() || std::exchange(printed_, now) == now) return;
    fmt::print("{}\n", now);
    std::fflush(stdout);
  }
  // Returns the phase to print, or an empty string.
  [[nodiscard]] std::string phase() const {
    const Json& manual = last_["manual"];
    if (what_ != WaitFor::Picture) {
      const std::string state = manual.value("state", "");
      return state == "idle" ? "" : printable(state);
    }
    const Json& picture = manual["picture"];
    return picture.is_string() ? printable(picture.get<std::string>()) + " is shown; Ctrl-C stops it" : "";
  }
  [[nodiscard]] int end() const {
    const Json& manual = last_["manual"];
    // After `stop`, a problem such as "stopped" in the status is a success.
    const bool well = what_ == WaitFor::Rest        ? manual.value("dark", false)
                      : what_ == WaitFor::Operation ? manual["problem"].is_null()
                                                    : true;
    if (json_ || what_ == WaitFor::Picture) return well ? kOk : kFailed;
    if (well) {
      if (!silent_) print_manual(last_);
      return kOk;
    }
    const std::string problem =
        manual["problem"].is_string() ? manual["problem"].get<std::string>() : "the light may be on";
    fmt::print(stderr, "contourctl: {}\n", printable_lines(problem));
    return kFailed;
  }

  WaitFor what_;
  bool json_, silent_, begun_ = false;
  Json last_;
  std::string printed_;
};

int carry_out(DaemonConnection& connection, const ClientOptions& options, const Request& request,
              WaitFor what, Progress progress) {
  connection.send("watch", kWatch);
  connection.send(request.method, kRequest, request.parameters);
  Operation operation(what, options.json, progress);
  while (true) {
    if (const std::optional<int> code = operation.take(connection.receive())) return *code;
  }
}

Mask read_picture(const std::string& path) {
  try {
    return read_png_as_grey(path);
  } catch (const std::system_error&) {
    throw;
  } catch (const std::runtime_error& error) {
    throw ModelError(fmt::format("{}: {}", path, error.what()));
  }
}

// Returns the mask that contourd would expose at that height with that configuration.
Mask mask_at_z(const ShowOptions& show) {
  const std::filesystem::path model = show.what;
  const PrinterConfig printer = load_printer_config(show.printer, Places::Elsewhere);
  const PreparedJob job = prepare_model({model_stem(model.filename().string()), model, show.ticket}, printer);
  const std::optional<Nanometers> height = to_nanometers(Millimeters{*show.at_z_mm});
  if (!height || *height < Nanometers{} || to_millimeters(*height).count() > job.summary.height_mm)
    throw UsageError(fmt::format("--at-z {:g}: {} extends from 0 to {:.6g} mm", *show.at_z_mm, show.what,
                                 job.summary.height_mm));
  MaskBudget budget(MaskBudget::Clock::now() + printer.mask_budget);
  const Mask* const mask = job.plan.engine->mask_within(*height, budget);
  if (mask == nullptr)
    throw ModelError(
        fmt::format("{}: the mask at {:g} mm takes longer than mask_budget_ms", show.what, *show.at_z_mm));
  return *mask;
}

// Uploads a picture. Returns nullopt, or the daemon's reply if it refused a piece.
std::optional<Json> upload(DaemonConnection& connection, std::span<const std::uint8_t> bytes) {
  constexpr std::size_t kPieceBytes = 5'700;  // base64 of this fits in one message
  for (std::size_t from = 0; from < bytes.size(); from += kPieceBytes) {
    const auto piece = bytes.subspan(from, std::min(kPieceBytes, bytes.size() - from));
    connection.send("upload", kUpload, {{"from", from}, {"data", base64(piece)}});
    Json reply = connection.receive();
    if (reply.contains("error")) return reply;
  }
  return std::nullopt;
}

// Returns the request with the parameters that were given.
Request manual_request(const char* method, const ManualArgs& args) {
  Request request{method};
  const auto set = [&request](const char* name, const auto& value) {
    if (value) request.parameters[name] = *value;
  };
  const auto set_if = [&request](const char* name, bool value) {
    if (value) request.parameters[name] = true;
  };
  set("to_mm", args.to_mm);
  set("by_mm", args.by_mm);
  set("speed_mm_s", args.speed_mm_s);
  set("seconds", args.seconds);
  set_if("plate_is_clear", args.plate_is_clear);
  set_if("in_resin", args.in_resin);
  set_if("unhomed", args.unhomed);
  return request;
}

// Returns the names of the test patterns.
std::vector<std::string> pattern_names() {
  std::vector<std::string> names;
  for (const TestPattern pattern : kTestPatterns)
    names.emplace_back(name_of(pattern));
  return names;
}

// Powers the projector on and waits until its lamp is warm, or powers it off.
int power_projector(const ClientOptions& options, bool on) {
  const int code =
      control_by_hand(options, {"projector", {{"power", on ? "on" : "off"}}}, WaitFor::Operation);
  if (code == kOk && !options.json) fmt::print("projector {}\n", on ? "on" : "is powering off");
  return code;
}

// Shows the picture until it ends.
int show_by_hand(const ClientOptions& options, const ShowOptions& show) {
  Request request{"show"};
  if (show.seconds) request.parameters["seconds"] = *show.seconds;
  // Names of patterns contain neither a dot nor a slash.
  if (!show.at_z_mm && show.what.find_first_of("./") == std::string::npos) {
    request.parameters["pattern"] = show.what;
    return control_by_hand(options, request, WaitFor::Picture);
  }
  const Mask picture = show.at_z_mm ? mask_at_z(show) : read_picture(show.what);
  DaemonConnection connection(options.socket);
  if (const std::optional<Json> refusal = upload(connection, encode_png(picture))) {
    if (!options.json) return print_refusal(*refusal);
    print_json(*refusal);
    return kFailed;
  }
  request.parameters["uploaded"] = true;
  return carry_out(connection, options, request, WaitFor::Picture, Progress::Printed);
}

// Turns the light on after the user has confirmed it, and waits until it is off. Throws UsageError if
// standard input is not a terminal and `confirmed` is false.
int light_by_hand(const ClientOptions& options, const Request& request, bool confirmed) {
  if (!confirmed) {
    if (::isatty(STDIN_FILENO) == 0)
      throw UsageError("light on: standard input is not a terminal, so --confirm is required");
    fmt::print("UV light for {} s. Eyes protected, no one near the vat? yes/no: ",
               request.parameters.value("seconds", 0.0));
    std::fflush(stdout);
    std::array<char, 16> answer{};
    const char* const line = std::fgets(answer.data(), answer.size(), stdin);
    if (line == nullptr || std::string_view(line) != "yes\n") {
      fmt::print(stderr, "contourctl: the light stays off: only \"yes\" turns it on\n");
      return kFailed;
    }
  }
  return control_by_hand(options, request, WaitFor::Operation);
}

// Adds a command that sends a request and waits.
Command& add_by_hand(Command& parent, const char* name, const char* help, const char* method,
                     ManualArgs& args, WaitFor what = WaitFor::Operation) {
  Command& command = parent.add(name, help);
  const ClientOptions& client = add_client_options(command);
  command.run = [&client, &args, method, what] {
    return control_by_hand(client, manual_request(method, args), what);
  };
  return command;
}

void add_motion(Command& program, ManualArgs& args) {
  add_by_hand(program, "home", "Home the plate: move it to its limit switch", "home", args)
      .option("--plate-is-clear", args.plate_is_clear, kPlateIsClearHelp);
  Command& move = add_by_hand(program, "move", "Move the plate", "move", args);
  move.option("--to", args.to_mm, "Height above the film, mm").in_group("target");
  const Option& by =
      move.option("--by", args.by_mm, "Distance upwards, mm; negative: downwards").in_group("target");
  const Option& speed =
      move.option("--speed", args.speed_mm_s, "Speed, mm/s (default: the configured travel speed)");
  move.option("--unhomed", args.unhomed, "Move slowly, at most 2 mm, from an unknown position")
      .needs(by)
      .excludes(speed);
  move.option("--plate-is-clear", args.plate_is_clear, kPlateIsClearHelp);
  add_by_hand(program, "stop", "Stop manual control: motor stopped, light off, screen black", "stop", args,
              WaitFor::Rest);
  add_by_hand(program.add("motor", "Control the plate's motor"), "off", "Turn off the motor's current",
              "motor_off", args);
}

void add_light(Command& program, ManualArgs& args) {
  Command& light = program.add("light", "Control the projector's light");
  Command& on = light.add("on", "Turn the light on, with the current picture");
  on.option("--seconds", args.seconds, "Duration, s").required();
  on.option("--confirm", args.confirm, "Confirm that eyes are protected, without being asked");
  on.option("--in-resin", args.in_resin, "Allow light while the plate may be in the resin");
  const ClientOptions& client = add_client_options(on);
  on.run = [&client, &args] { return light_by_hand(client, manual_request("light_on", args), args.confirm); };
  add_by_hand(light, "off", "Turn the light off", "light_off", args, WaitFor::Rest);
}

void add_show(Command& program) {
  Command& command = program.add("show", "Show a test pattern or a picture on the display, until Ctrl-C");
  auto& show = command.arguments<ShowOptions>();
  command
      .option("PATTERN", show.what,
              "white, black, grid, checker, focus, border, dimensions; a PNG file of the display's "
              "size; or a model file")
      .required()
      .suggests(pattern_names, {".png"});
  command.option("--seconds", show.seconds, "Duration, s");
  const Option& at_z = command.option("--at-z", show.at_z_mm,
                                      "Show the mask of a model file at this height above the plate, mm");
  command.option("--printer", show.printer, kLikePrinterHelp).needs(at_z);
  command.option("--ticket", show.ticket, "Ticket for the model file").needs(at_z);
  const ClientOptions& client = add_client_options(command);
  command.run = [&client, &show] { return show_by_hand(client, show); };
}

void add_projector(Command& program, ManualArgs& args) {
  Command& projector = program.add("projector", "Control the projector's power");
  add_by_hand(projector, "status", "Show the projector's state", "projector", args);
  const auto add = [&projector](const char* name, const char* help, bool on) {
    Command& command = projector.add(name, help);
    const ClientOptions& client = add_client_options(command);
    command.run = [&client, on] { return power_projector(client, on); };
  };
  add("on", "Turn the projector on and wait until it is warm; the light stays off", true);
  add("off", "Turn the projector off", false);
}

}  // namespace

int control_by_hand(const ClientOptions& options, const Request& request, WaitFor what, Progress progress) {
  DaemonConnection connection(options.socket);
  return carry_out(connection, options, request, what, progress);
}

ShownPicture::ShownPicture(const ClientOptions& options, const Mask& picture) : connection_(options.socket) {
  std::optional<Json> refusal = upload(connection_, encode_png(picture));
  if (!refusal) {
    Json reply = connection_.ask({"show", {{"uploaded", true}}});
    if (reply.contains("error")) refusal = std::move(reply);
  }
  if (refusal) throw DaemonError((*refusal)["error"].value("message", ""));
}

std::string describe_homing_shift(double shift_um) {
  return fmt::format("found {:.1f} um {} than at the previous homing", std::abs(shift_um),
                     shift_um < 0 ? "lower" : "higher");
}

void add_manual(Command& program) {
  auto& args = program.arguments<ManualArgs>();
  add_motion(program, args);
  add_light(program, args);
  add_show(program);
  add_projector(program, args);
}

}  // namespace contourd::ctl
