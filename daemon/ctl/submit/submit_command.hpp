// contourctl submit: queues models. Problems with the data or the daemon are thrown as exceptions (see
// exit_codes.hpp).
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "daemon/ctl/models/up_option.hpp"
#include "daemon/ctl/terminal/client.hpp"

namespace contourd::ctl {

struct SubmitOptions {
  std::vector<std::filesystem::path> models;
  // Keys of the tickets (config/ticket.schema.json); a value that is not given is not in the ticket.
  std::optional<std::string> resin, supports;
  std::optional<double> layer_height_um, scale;
  std::optional<double> exposure_ms, bottom_exposure_ms, lift_mm, settle_ms, rest_ms;
  std::optional<int> copies;
  std::optional<UpOption> up;
  bool fit = false;
  // Ticket instead of the keys above.
  std::optional<std::filesystem::path> ticket;
  std::optional<std::filesystem::path> spool;  // nullopt: ask contourd
  bool wait = false;
  // Configuration for the check of the ticket's settings, and for the forecast of time, resin and warnings.
  // nullopt: the installed configuration, if it can be read and names this spool.
  std::optional<std::filesystem::path> printer;
  bool yes = false;  // do not ask
};

// Puts the models into the queue, in their order, under names that no job has. Each model appears complete,
// after its ticket. Before the first one, checks all models and prints the forecast; if there is a warning,
// asks the user at the terminal. With `wait`, returns when all jobs have ended. Returns the exit code.
int submit(const ClientOptions& client, const SubmitOptions& options);

// Prints that the model is a job now; with --json also its forecast, if there is one.
void tell_submitted(const ClientOptions& client, const std::filesystem::path& model, const std::string& job,
                    const nlohmann::ordered_json& outlook = {});

}  // namespace contourd::ctl
