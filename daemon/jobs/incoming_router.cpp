#include "daemon/jobs/incoming_router.hpp"

#include <fmt/format.h>

#include "daemon/config/job_ticket.hpp"
#include "daemon/system/readable.hpp"

namespace contourd {

void IncomingRouter::plate_waits(const std::string& file, const std::vector<std::string>& missing) {
  std::string names;
  for (const std::string& name : missing)
    names += (names.empty() ? "" : ", ") + printable(name);
  log_.info("incomplete",
            fmt::format("{}: waits for {}, which its {} names", printable(file), names, kPlateTicket),
            file_fields(file));
}

void IncomingRouter::ignored(const std::string& file, WhyIgnored why) {
  log_.warning("ignored", fmt::format("{}: is ignored: {}", printable(file), sentence_for(why)),
               file_fields(file));
}

void IncomingRouter::more_ignored(std::size_t files) {
  log_.warning("ignored", fmt::format("{} more in incoming are ignored", files));
}

void IncomingRouter::incoming_lost(const std::string& why) {
  log_.error("spool",
             fmt::format("nothing arrives until there is an incoming folder again: {}", printable(why)));
}

void IncomingRouter::incoming_replaced() {
  log_.warning("spool", "incoming was removed, replaced or mounted over; the new folder is watched");
}

}  // namespace contourd
