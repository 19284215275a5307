// The jobs that have ended since contourd started, the latest of them only. Event loop's thread only.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
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
  // How many have ended so, each outcome that there is, of all.
  using Counts = std::map<std::string, std::uint64_t, std::less<>>;
  [[nodiscard]] const Counts& counts() const { return counts_; }

 private:
  std::deque<EndedJob> jobs_;
  Counts counts_{{"done", 0}, {"cancelled", 0}, {"failed", 0}};
};

}  // namespace contourd
