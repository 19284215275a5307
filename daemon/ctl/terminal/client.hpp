// Requests of contourctl to a running contourd. Problems with the data or the daemon are thrown as exceptions
// (see exit_codes.hpp).
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "daemon/client/daemon_connection.hpp"

namespace contourd::ctl {

struct ClientOptions {
  std::filesystem::path socket;
  bool json = false;
};

// Sends the request. Prints the result with `print`, or with --json the answer unchanged. Returns the exit
// code.
int request(const ClientOptions& options, const Request& request,
            void (*print)(const nlohmann::ordered_json& result));

// Returns the given spool folder, or else contourd's. Throws DaemonError if contourd does not report it.
[[nodiscard]] std::filesystem::path find_spool(const ClientOptions& options,
                                               const std::optional<std::filesystem::path>& given);

// Returns the remaining print time of the job in a status, in readable form.
[[nodiscard]] std::string time_left(const nlohmann::ordered_json& job);

void print_status(const nlohmann::ordered_json& status);

}  // namespace contourd::ctl
