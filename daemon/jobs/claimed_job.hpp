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
  // As they were when its turn came; nothing where its ticket is a reason to refuse it.
  std::optional<JobSettings> settings;
  TimePoint turn_came;           // when it arrived, or its waiting ended; CLOCK_MONOTONIC
  std::int64_t key = 0;          // in the history (EndedJob)
  bool unheld_accepted = false;  // by its owner: what cannot be held is printed as it is
};

}  // namespace contourd
