// What contourctl setup tries out on the printer, by contourd as it runs with the new configuration, and what
// follows from it for the answers. Not thread-safe.
#pragma once

#include <filesystem>
#include <functional>

#include "daemon/ctl/setup/setup_dialog.hpp"
#include "daemon/ctl/setup/setup_record.hpp"
#include "daemon/ctl/terminal/client.hpp"

namespace contourd::ctl {

struct SetupChecks {
  const ClientOptions& client;
  SetupDialog& dialog;
  SetupRecord& record;
  std::filesystem::path config;
  std::function<void()> keep;  // the record, as it is now
  // The configuration, as the answers are now. False: that would not be good, which is said.
  std::function<bool()> write;
};

// Makes those checks that have not been passed, in their order; each can be skipped. Says at the end which
// have been, and how they are made later. Blocks. Throws SetupLeft.
void check_printer(const SetupChecks& checks);

// The record knows that contourd has not taken the configuration as it is written now.
void expect_restart(SetupRecord& record);

}  // namespace contourd::ctl
