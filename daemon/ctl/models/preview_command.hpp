// contourctl preview. Prints its result and returns the exit code; what is wrong with the data or the daemon
// comes out as an exception (see exit_codes.hpp).
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "daemon/ctl/terminal/client.hpp"

namespace contourd::ctl {

struct PreviewOptions {
  std::string subject;       // a model's file, or a job's name
  std::optional<int> layer;  // its mask, from 1; without it the shaded model
  // The printer's configuration; the installed one where it is needed and not given.
  std::optional<std::filesystem::path> printer;
  std::optional<std::filesystem::path> ticket;  // of a file
  std::optional<std::filesystem::path> spool;   // contourd is asked for it when it is not given
  std::optional<std::filesystem::path> output;  // a PNG file, or "-"; without it, it is drawn
};

int preview(const ClientOptions& client, const PreviewOptions& options);

}  // namespace contourd::ctl
