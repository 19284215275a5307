// The jobs that have ended since contourd started, the latest of them only. Event loop's thread only. What is
// known for longer is in a database (history_store.hpp).
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "daemon/spool/job_files.hpp"

namespace contourd {

// What a job was printed with, and what that took. All 0 and empty of one that was not printed.
struct JobFigures {
  std::string resin;     // its profile's name
  std::string settings;  // for a person
  std::vector<std::string> warnings;
  double height_mm = 0;
  double layer_height_um = 0;                   // the first layer's
  std::int64_t layers = 0, layers_exposed = 0;  // expected; that had all their light
  double print_time_s = 0;                      // by the machine's clock
  double lit_s = 0, light_asked_s = 0;          // of all exposures: at most, and as it was meant
  double most_light_over_ms = 0;                // of one layer, beyond what was meant
  double resin_ml = 0;                          // of the layers that had light
  std::int64_t interruptions = 0, late_steps = 0;
};

struct EndedJob {
  std::string name, outcome, reason;
  nlohmann::ordered_json analysis{};  // in short; null when there is none
  JobFigures figures{};
  std::chrono::system_clock::time_point began{}, ended{};  // began: its turn came
  std::int64_t key = 0;  // tells jobs of the kept history apart, for ever; 0 where it is not known
  ReportFiles reports{};
};

// As the control socket tells it (docs/control-api.md, "A job of the history").
[[nodiscard]] nlohmann::ordered_json history_json(const EndedJob& job);

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
  // How many have ended, of all.
  [[nodiscard]] std::int64_t total() const { return total_; }

 private:
  std::deque<EndedJob> jobs_;
  std::int64_t total_ = 0;
  Counts counts_{{"done", 0}, {"cancelled", 0}, {"failed", 0}};
};

}  // namespace contourd
