// Requests of contourctl to a running contourd. Problems with the data or the daemon are thrown as exceptions
// (see exit_codes.hpp).
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "daemon/client/daemon_connection.hpp"
#include "daemon/ctl/terminal/command.hpp"

namespace contourd::ctl {

// Returns the socket that the environment variable CONTOURD_SOCKET names, or the installed contourd's.
[[nodiscard]] std::filesystem::path default_socket();

struct ClientOptions {
  std::filesystem::path socket = default_socket();
  bool json = false;
};

// Help texts of options that several commands have.
inline constexpr const char* kSpoolHelp = "Spool folder, if contourd is not running";
inline constexpr const char* kJobHelp = "Name of the job, or of its file in incoming";

void print_status(const nlohmann::ordered_json& status);
// Prints the message as one line of JSON.
void print_json(const nlohmann::ordered_json& message);
// Prints the reason in an answer with an error to stderr. Returns the exit code.
int print_refusal(const nlohmann::ordered_json& answer);
// Returns this member's text in printable form, or an empty text if there is no such member or it is no text.
[[nodiscard]] std::string text_of(const nlohmann::ordered_json& object, const char* key);

// Adds the option --socket. Returns its value, which lives as long as the command.
ClientOptions& add_socket_option(Command& command);
// Adds --socket and --json.
ClientOptions& add_client_options(Command& command);
// Adds --socket and --json for the variables of the command's group, which has these options, too.
void add_client_options(Command& command, ClientOptions& of_group);
// Adds a command that calls a method without parameters, and prints the result.
void add_request(Command& parent, const char* name, const char* help, const char* method,
                 void (*print)(const nlohmann::ordered_json& result) = print_status);

// Sends the request. Prints the result with `print`, or with --json the answer unchanged. Returns the exit
// code.
int request(const ClientOptions& options, const Request& request,
            void (*print)(const nlohmann::ordered_json& result));

// Returns the given spool folder, or else contourd's. Throws DaemonError if contourd does not report it.
[[nodiscard]] std::filesystem::path find_spool(const ClientOptions& options,
                                               const std::optional<std::filesystem::path>& given);

// Returns the end of a job, as in a status: "tower: done", or "tower: failed: " and the reason, which may
// have several lines.
[[nodiscard]] std::string end_of(const nlohmann::ordered_json& ended);

// Returns seconds of a reply in readable form: "12 min 30 s".
[[nodiscard]] std::string readable_seconds(double seconds);

}  // namespace contourd::ctl
