#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <string>
#include <string_view>

#include "daemon/client/daemon_connection.hpp"
#include "daemon/ctl/commands/commands.hpp"
#include "daemon/ctl/commands/manual_command.hpp"
#include "daemon/ctl/terminal/client.hpp"
#include "daemon/ctl/terminal/exit_codes.hpp"
#include "daemon/system/readable.hpp"

namespace contourd::ctl {
namespace {

using Json = DaemonConnection::Json;

struct ResumeArgs {
  bool trust_position = false, yes = false;
};

// Returns the print that a power cut ended; null if there is none.
Json interrupted_print(const ClientOptions& options) {
  DaemonConnection connection(options.socket);
  return connection.ask({"status"}).value("/result/interrupted"_json_pointer, Json());
}

// Says what trusting the recorded position assumes, and asks the user. Throws UsageError if standard input is
// not a terminal.
bool agrees_to_trust(const std::string& assumed) {
  fmt::print(
      "This assumes that {}. If the plate stands elsewhere, the print is spoilt, and a plate that is "
      "lower may hit the film.\n",
      printable(assumed));
  if (::isatty(STDIN_FILENO) == 0)
    throw UsageError("resume --trust-position: standard input is not a terminal, so --yes is required");
  fmt::print("Continue the print? yes/no: ");
  std::fflush(stdout);
  std::array<char, 16> answer{};
  const char* const line = std::fgets(answer.data(), answer.size(), stdin);
  return line != nullptr && std::string_view(line) == "yes\n";
}

int resume(const ClientOptions& options, const ResumeArgs& args) {
  const Json interrupted = interrupted_print(options);
  if (!interrupted.is_object() && !args.trust_position) return request(options, {"resume"}, print_status);
  const std::string assumed = interrupted.is_object() ? text_of(interrupted, "trust") : "";
  if (args.trust_position && !args.yes && !assumed.empty() && !agrees_to_trust(assumed)) {
    fmt::print(stderr, "contourctl: nothing moves: only \"yes\" continues the print\n");
    return kFailed;
  }
  return request(options, {"go_on", {{"trust_position", args.trust_position}}}, print_status);
}

}  // namespace

void add_resume(Command& program) {
  Command& command =
      program.add("resume", "Continue after a pause or a power cut, or release the queue after a failure");
  auto& args = command.arguments<ResumeArgs>();
  const Option& trust = command.option("--trust-position", args.trust_position,
                                       "After a power cut: trust the recorded height of the plate");
  command.option("--yes", args.yes, "Do not ask for confirmation").needs(trust);
  const ClientOptions& client = add_client_options(command);
  command.run = [&client, &args] { return resume(client, args); };
}

void add_rescue(Command& program) {
  Command& command = program.add("rescue", "Lift the part of an interrupted print out of the resin");
  const ClientOptions& client = add_client_options(command);
  command.run = [&client] { return control_by_hand(client, {"rescue"}, WaitFor::Operation); };
}

}  // namespace contourd::ctl
