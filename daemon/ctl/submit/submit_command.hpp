// contourctl submit. Prints its result and returns the exit code; what is wrong with the data or the daemon
// comes out as an exception (see exit_codes.hpp).
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
  // The tickets' keys of these names (config/ticket.schema.json); what is not given is not in the ticket.
  std::optional<std::string> resin, supports;
  std::optional<double> layer_height_um, scale;
  std::optional<double> exposure_ms, bottom_exposure_ms, lift_mm, settle_ms, rest_ms;
  std::optional<int> copies;
  std::optional<UpOption> up;
  bool fit = false;
  // In the place of all these.
  std::optional<std::filesystem::path> ticket;
  std::optional<std::filesystem::path> spool;  // contourd is asked for it when it is not given
  bool wait = false;
  // By which a ticket's settings are checked beforehand, and time, resin and warnings told. The installed one
  // where it is not given, can be read, and has that spool.
  std::optional<std::filesystem::path> printer;
  bool yes = false;  // nobody is asked
};

// Puts the models into the queue, in their order, under names that no job has. Each appears there whole, its
// ticket before it. What can be seen to be wrong with any is told before the first is put there, and what is
// to be expected of them; where that is a warning, whoever sits at the terminal is asked. With `wait`, until
// all have ended.
int submit(const ClientOptions& client, const SubmitOptions& options);

// That the model is a job now; with what is to be expected of it, where that is known, for programs.
void tell_submitted(const ClientOptions& client, const std::filesystem::path& model, const std::string& job,
                    const nlohmann::ordered_json& outlook = {});

}  // namespace contourd::ctl
