// contourctl preview: draws a model or a job. Prints its result and returns the exit code. Problems with the
// data or the daemon are thrown as exceptions (see exit_codes.hpp).
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "daemon/ctl/terminal/client.hpp"

namespace contourd::ctl {

struct PreviewOptions {
  std::string subject;       // a model's file, or a job's name
  std::optional<int> layer;  // draw this layer's mask, counted from 1; nullopt: the shaded model
  // Configuration of the printer; nullopt: the installed one, if one is needed.
  std::optional<std::filesystem::path> printer;
  std::optional<std::filesystem::path> ticket;  // for a model's file
  std::optional<std::filesystem::path> spool;   // nullopt: ask contourd
  std::optional<std::filesystem::path> output;  // a PNG file, or "-"; nullopt: draw in the terminal
};

int preview(const ClientOptions& client, const PreviewOptions& options);

}  // namespace contourd::ctl
