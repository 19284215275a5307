// contourctl offer. Prints its result and returns the exit code; what is wrong with the folder or the spool
// comes out as an exception (see exit_codes.hpp).
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "daemon/ctl/terminal/client.hpp"

namespace contourd::ctl {

struct OfferOptions {
  std::filesystem::path folder;
  std::optional<std::filesystem::path> spool;  // contourd is asked for it when it is not given
  // What was taken before is noted here, and not taken again; by the label, and what a file is.
  std::optional<std::filesystem::path> once;
  std::string label;
};

// Puts the models of a folder that nobody vouches for into the queue, as submit does, each with the ticket
// beside it; so many and so much at most. What it does not take is told, and keeps none of the others.
int offer(const ClientOptions& client, const OfferOptions& options);

}  // namespace contourd::ctl
