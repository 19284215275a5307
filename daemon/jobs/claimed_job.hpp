// A job whose turn has come. A value.
#pragma once

#include <cstdint>
#include <optional>

#include "daemon/prepare/job_settings.hpp"
#include "daemon/spool/job_files.hpp"
#include "hw/clock.hpp"

namespace contourd {

struct ClaimedJob {
  JobFiles files;  // in printing/
  // The settings when its turn came; nullopt if its ticket is a reason to refuse it.
  std::optional<JobSettings> settings;
  TimePoint turn_came;           // time of its arrival, or of the end of its wait; CLOCK_MONOTONIC
  std::int64_t key = 0;          // in the history (EndedJob)
  bool unheld_accepted = false;  // a user accepted that places cannot be held
};

}  // namespace contourd
