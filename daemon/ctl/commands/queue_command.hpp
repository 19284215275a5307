// contourctl queue and accept; the print functions are for request() in client.hpp.
#pragma once

#include <string>

#include "daemon/ctl/terminal/client.hpp"

namespace contourd::ctl {

// Prints at least two lines per job: number and file, then state and details.
void print_queue(const nlohmann::ordered_json& queue);
// Prints all details of the one job in the answer.
void print_waiting_job(const nlohmann::ordered_json& queue);

// Removes the job from the queue, and prints where its files go. Returns the exit code.
int remove_from_queue(const ClientOptions& options, const std::string& job);
// Accepts a job with its findings, so that it is printed. Returns the exit code.
int accept_job(const ClientOptions& options, const std::string& job);

}  // namespace contourd::ctl
