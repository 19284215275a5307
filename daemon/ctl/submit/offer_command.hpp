// contourctl offer: queues the models of an untrusted folder. Problems with the folder or the spool are
// thrown as exceptions (see exit_codes.hpp).
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "daemon/ctl/terminal/client.hpp"

namespace contourd::ctl {

struct OfferOptions {
  std::filesystem::path folder;
  std::optional<std::filesystem::path> spool;  // nullopt: ask contourd
  // Record of the files taken, which are not taken again. A file is identified by `label`, path, size and
  // time.
  std::optional<std::filesystem::path> once;
  std::string label;
};

// Puts the models of the folder into the queue, as submit does, each with the ticket next to it. The number
// and the total size are limited. Reports each file that is not taken, and continues with the others. Returns
// the exit code.
int offer(const ClientOptions& client, const OfferOptions& options);

}  // namespace contourd::ctl
