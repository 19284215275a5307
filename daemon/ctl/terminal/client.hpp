// What contourctl asks of a daemon. Prints its result and returns the exit code; what is wrong
// with the data or the daemon comes out as an exception (see exit_codes.hpp).
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

// Sends it, and prints its result for a person, by `print`, or the answer as it came.
int request(const ClientOptions& options, const Request& request,
            void (*print)(const nlohmann::ordered_json& result));

// The spool's folder: the given one, or contourd's. Throws DaemonError where contourd does not tell.
[[nodiscard]] std::filesystem::path find_spool(const ClientOptions& options,
                                               const std::optional<std::filesystem::path>& given);

// Returns the remaining print time of a status' job, for a person.
[[nodiscard]] std::string time_left(const nlohmann::ordered_json& job);

void print_status(const nlohmann::ordered_json& status);

}  // namespace contourd::ctl
