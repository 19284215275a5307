// The latest jobs that have ended since contourd started. Event loop's thread only. The jobs of earlier runs
// are in a database (history_database.hpp).
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "daemon/spool/job_ends.hpp"
#include "daemon/spool/job_files.hpp"

namespace contourd {

// A job's settings and measurements. All members are 0 or empty if the job was not printed.
struct JobFigures {
  std::string resin;     // the resin profile's name
  std::string settings;  // a text for the user
  std::vector<std::string> warnings;
  double height_mm = 0;
  double layer_height_um = 0;                   // the first layer's
  std::int64_t layers = 0, layers_exposed = 0;  // layers of the job, and layers that were fully exposed
  double print_time_s = 0;                      // measured by the machine's clock
  double lit_s = 0, light_asked_s = 0;  // sums over all exposures: upper bound of the light, and setpoint
  double most_light_over_ms = 0;        // largest excess of a layer's exposure over its setpoint
  double resin_ml = 0;                  // volume of the layers that had light
  std::int64_t interruptions = 0, late_steps = 0;
};

struct EndedJob {
  std::string name, outcome, reason;
  nlohmann::ordered_json analysis{};  // a summary; null if there is none
  JobFigures figures{};
  std::chrono::system_clock::time_point began{}, ended{};  // began: when the job's turn came
  std::int64_t key = 0;  // identifies the job in the database, see HistoryDatabase::begin(); 0 if not known
  ReportFiles reports{};
};

// Return the same end for the record, without its analysis, and back.
[[nodiscard]] JobEnd job_end(const EndedJob& job);
[[nodiscard]] EndedJob ended_job(const JobEnd& end);

// Returns the job in the format of the control socket (docs/control-api.md, "A job of the history").
[[nodiscard]] nlohmann::ordered_json history_json(const EndedJob& job);

class JobHistory {
 public:
  // Maximum number of jobs; older ones are dropped.
  static constexpr std::size_t kLongest = 100;

  void add(EndedJob job);
  // The jobs, the latest last.
  [[nodiscard]] const std::deque<EndedJob>& jobs() const { return jobs_; }
  // The number of jobs with each outcome, dropped ones included.
  using Counts = std::map<std::string, std::uint64_t, std::less<>>;
  [[nodiscard]] const Counts& counts() const { return counts_; }
  // The number of jobs that have ended, dropped ones included.
  [[nodiscard]] std::int64_t total() const { return total_; }

 private:
  std::deque<EndedJob> jobs_;
  std::int64_t total_ = 0;
  Counts counts_{{"done", 0}, {"cancelled", 0}, {"failed", 0}};
};

}  // namespace contourd
