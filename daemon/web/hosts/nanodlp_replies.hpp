// NanoDLP's answers, as far as DragonFruit and Orion read them. Thread-safe (no state).
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/web/hosts/host_jobs.hpp"

namespace contourd::web {

// Returns the answer to /status. Without a job it has neither plate nor layers, unless the last print was
// done, whose layers clients then take for its end.
[[nodiscard]] ControlLink::Json nanodlp_status(const HostStatus& status, std::string_view version);
// Returns the answer to /plates/list/json. A plate that is not checked yet has no layers.
[[nodiscard]] ControlLink::Json nanodlp_plates(const std::vector<HostJob>& jobs);
// Returns the answers to /json/db/profiles.json and /json/db/machine.json, by contourd's `resins`. The
// profiles are locked: they are changed on the printer.
[[nodiscard]] ControlLink::Json nanodlp_profiles(const ControlLink::Json& resins);
[[nodiscard]] ControlLink::Json nanodlp_machine(const std::string& printer, const ControlLink::Json& resins);
// Returns the name of the resin with this number; nullopt if there is none, or several have it.
[[nodiscard]] std::optional<std::string> nanodlp_resin(const ControlLink::Json& resins,
                                                       std::string_view number);
// Returns the number in a text of digits; nullopt for another text, and for 0.
[[nodiscard]] std::optional<std::uint32_t> nanodlp_number(std::string_view text);

}  // namespace contourd::web
