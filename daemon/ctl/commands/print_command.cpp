#include <fmt/format.h>

#include <charconv>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

#include "core/layers/layers.hpp"
#include "daemon/client/daemon_connection.hpp"
#include "daemon/ctl/commands/commands.hpp"
#include "daemon/ctl/terminal/client.hpp"
#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/ctl/terminal/suggestions.hpp"
#include "daemon/ctl/terminal/terminal.hpp"
#include "daemon/print/print_settings.hpp"
#include "daemon/system/readable.hpp"

namespace contourd::ctl {
namespace {

using Json = DaemonConnection::Json;

struct PauseArgs {
  std::optional<int> at_layer;
  std::optional<double> at_mm;
};

void add_pause(Command& program) {
  Command& command = program.add("pause", "Pause the print after the current layer, or later");
  auto& args = command.arguments<PauseArgs>();
  const Option& layer =
      command.option("--at-layer", args.at_layer, "Pause before layer N").from_to(1, kMaxLayers);
  command.option("--at-mm", args.at_mm, "Pause when the part is this high, mm").excludes(layer);
  const ClientOptions& client = add_client_options(command);
  command.run = [&client, &args] {
    Json parameters = Json::object();
    if (args.at_layer) parameters["at_layer"] = *args.at_layer;
    if (args.at_mm) parameters["at_mm"] = *args.at_mm;
    return request(client, {"pause", parameters}, print_status);
  };
}

struct SetArgs {
  std::string setting, value;
};

// Returns the number, which may have the unit %; a mistake is a usage error.
double number_of(const SetArgs& args) {
  const bool percent = (args.setting == "exposure" || args.setting == "light") && args.value.ends_with('%');
  const std::string_view digits =
      std::string_view(args.value).substr(0, args.value.size() - (percent ? 1 : 0));
  double number = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  if (error != std::errc{} || end != digits.data() + digits.size())
    throw UsageError(fmt::format("VALUE {}: expected a number, such as 110", printable(args.value)));
  return number;
}

void add_set(Command& program) {
  Command& command =
      program.add("set", "Change a setting of the print from the next layer or, of a rise, from now on");
  auto& args = command.arguments<SetArgs>();
  command
      .option("SETTING", args.setting,
              "exposure, lift, lift-speed, retract-speed, rest, speed, light or margin")
      .required()
      .one_of({kPrintSettings.begin(), kPrintSettings.end()});
  command.option("VALUE", args.value, "exposure and light in %, mm, mm/s, rest in ms, speed in mm/h")
      .required();
  const ClientOptions& client = add_client_options(command);
  command.run = [&client, &args] {
    return request(client, {"set", {{"setting", args.setting}, {"value", number_of(args)}}}, print_status);
  };
}

void print_copies(const Json& result) {
  for (const Json& copy : result["copies"]) {
    const Json& from = copy["excluded_from"];
    fmt::print("{:>3}  {}, at {} mm{}\n", copy.value("number", 0), text_of(copy, "name"),
               coordinates({copy["position_mm"][0].get<double>(), copy["position_mm"][1].get<double>()}, 1),
               from.is_number() ? fmt::format(", dark from layer {} on", from.get<int>()) : "");
  }
  if (const auto more = result.value("more", std::size_t{0}); more > 0) fmt::print("and {} more\n", more);
}

void add_exclude(Command& program) {
  Command& command = program.add("exclude", "Leave a failed copy dark from the next layer on, or list all");
  auto& copy = command.arguments<std::string>();
  command.option("COPY", copy, "Number or name of the copy; without it, the copies are listed");
  const ClientOptions& client = add_client_options(command);
  command.run = [&client, &copy] {
    if (copy.empty()) return request(client, {"copies"}, print_copies);
    return request(client, {"exclude", {{"copy", copy}}}, print_status);
  };
}

void print_vat(const Json& result) {
  if (result["ml"].is_number())
    fmt::print("the vat holds about {:.0f} ml of resin\n", result["ml"].get<double>());
  else
    fmt::print("the amount of resin in the vat is unknown: record it with contourctl vat filled ML\n");
}

void print_preflight(const Json& result) {
  for (const Json& check : result["checks"])
    print_wrapped(fmt::format("{:<7} {:<12}", text_of(check, "verdict"), text_of(check, "check")),
                  text_of(check, "text"));
}

// Returns kFailed if a check refuses.
int check_before_print(const ClientOptions& client, const std::string& job) {
  DaemonConnection connection(client.socket);
  const Json answer = connection.ask({"preflight", {{"job", job}}});
  if (client.json) print_json(answer);
  if (answer.contains("error")) return client.json ? kFailed : print_refusal(answer);
  if (!client.json) print_preflight(answer["result"]);
  return answer["result"].value("verdict", "") == "refuse" ? kFailed : kOk;
}

}  // namespace

void add_preflight(Command& program) {
  Command& command = program.add("preflight", "Check the printer and a waiting job before its first light");
  auto& job = command.arguments<std::string>();
  command.option("JOB", job, kJobHelp).required().suggests(waiting_jobs);
  const ClientOptions& client = add_client_options(command);
  command.run = [&client, &job] { return check_before_print(client, job); };
}

void add_print_control(Command& program) {
  add_pause(program);
  add_set(program);
  add_exclude(program);
  add_resume(program);
  add_request(program, "cancel", "Cancel the current print: light off, plate up", "cancel");
  add_request(program, "plate-cleared", "Confirm that the plate is free for the next job", "plate_cleared");
  add_rescue(program);
}

void add_vat(Command& program) {
  Command& vat = program.add("vat", "Show how much resin the vat holds, or record that it was filled");
  ClientOptions& client = add_client_options(vat);
  vat.run = [&client] { return request(client, {"vat"}, print_vat); };
  Command& filled = vat.add("filled", "Record the amount of resin in the vat after filling");
  auto& ml = filled.arguments<double>();
  filled.option("ML", ml, "Resin in the vat, ml").required();
  add_client_options(filled, client);
  filled.run = [&client, &ml] { return request(client, {"vat", {{"filled_ml", ml}}}, print_vat); };
}

}  // namespace contourd::ctl
