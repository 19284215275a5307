// What contourctl does with the queue: see request() in client.hpp.
#pragma once

#include <string>

#include "daemon/ctl/terminal/client.hpp"

namespace contourd::ctl {

// Two lines a job: number and file, and what is known of it.
void print_queue(const nlohmann::ordered_json& queue);
// All that is known of the one job that was asked for.
void print_waiting_job(const nlohmann::ordered_json& queue);

// Says what becomes of the job's files. Returns the exit code.
int remove_from_queue(const ClientOptions& options, const std::string& job);
// Has it printed with what was found in it. Returns the exit code.
int accept_job(const ClientOptions& options, const std::string& job);

}  // namespace contourd::ctl
