// The jobs that have ended since contourd started, the latest of them only. Event loop's thread only.
#pragma once

#include <cstddef>
#include <deque>
#include <nlohmann/json.hpp>
#include <string>

#include "daemon/job_files.hpp"

namespace contourd {

struct EndedJob {
  std::string name, outcome, reason;
  nlohmann::ordered_json analysis{};  // in short; null when there is none
  ReportFiles reports{};
};

class JobHistory {
 public:
  // Of older ones none is remembered.
  static constexpr std::size_t kLongest = 100;

  void add(EndedJob job);
  // The latest last.
  [[nodiscard]] const std::deque<EndedJob>& jobs() const { return jobs_; }

 private:
  std::deque<EndedJob> jobs_;
};

}  // namespace contourd
