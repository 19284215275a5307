// The checks of a waiting job before its first light. Thread-safe (no shared state).
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/config/wear_part.hpp"
#include "daemon/jobs/print_queue.hpp"

namespace contourd {

enum class Verdict { Pass, Warn, Refuse };
// Returns "pass", "warn" or "refuse".
[[nodiscard]] std::string_view name_of(Verdict verdict);

struct PreflightCheck {
  std::string_view name;
  Verdict verdict = Verdict::Pass;
  std::string text;  // a clause
};

// The facts about the printer that the checks need.
struct PreflightFacts {
  std::string not_ready;     // why the machine cannot print; empty if it can
  std::string disk_trouble;  // why the spool cannot take a print; empty if it can
  std::string queue_waits;   // why no job begins; empty if one can
  std::string display;       // "1920 x 1080 at 60 Hz"
  std::optional<double> vat_ml;
  std::optional<double> resin_c;  // nullopt if no sensor is configured, or it cannot be read
  std::string resin_trouble;      // why it cannot be read; empty if it can
  std::vector<WearPartUse> wear;  // empty if the history cannot be asked
  std::vector<std::string> due;   // sentences about parts that are due
};

// Returns the checks in the order of a list for the user. The scheduler keeps a job waiting for the reasons
// that refuse here.
[[nodiscard]] std::vector<PreflightCheck> preflight(const WaitingJob& job, const PreflightFacts& facts);
// Returns the checks as the reply of the method `preflight`.
[[nodiscard]] nlohmann::ordered_json preflight_json(const std::string& job,
                                                    const std::vector<PreflightCheck>& checks);

}  // namespace contourd
