// contourctl submit and offer: add jobs to the queue. Problems with the data or the daemon are thrown as
// exceptions (see exit_codes.hpp).
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "daemon/ctl/terminal/client.hpp"

namespace contourd::ctl {

// Puts the models into the queue, in their order, under names that no job has. Each model appears complete,
// after its ticket. Before the first one, checks all models and prints the forecast; if there is a warning,
// asks the user at the terminal. With --wait, returns when all jobs have ended.
void add_submit(Command& program);

// Puts the models of an untrusted folder into the queue, each with the ticket next to it. The number and the
// total size are limited. Reports each file that is not taken, and continues with the others.
void add_offer(Command& program);

// Prints that the model is a job now; with --json also its forecast, if there is one.
void tell_submitted(const ClientOptions& client, const std::filesystem::path& model, const std::string& job,
                    const nlohmann::ordered_json& outlook = {});

}  // namespace contourd::ctl
