// The checks of contourctl setup on the printer, by a contourd that runs with the new configuration; a check
// can correct an answer. Not thread-safe.
#pragma once

#include <filesystem>
#include <functional>

#include "daemon/ctl/setup/setup_record.hpp"
#include "daemon/ctl/terminal/client.hpp"
#include "daemon/ctl/terminal/dialog.hpp"

namespace contourd::ctl {

struct SetupChecks {
  const ClientOptions& client;
  Dialog& dialog;
  SetupRecord& record;
  std::filesystem::path config;
  std::function<void()> keep;  // saves the record
  // Writes the configuration from the current answers. Returns false after a message if it would not be
  // valid.
  std::function<bool()> write;
};

// Makes the checks that have not been passed yet, in their order; each can be skipped. At the end, lists the
// skipped checks and how to make them later. Blocks. Throws DialogLeft.
void check_printer(const SetupChecks& checks);

// Notes in the record that contourd must restart to read the new configuration.
void expect_restart(SetupRecord& record);

}  // namespace contourd::ctl
