// The history's tables: every job that was begun, and how it ended. Blocks, so a worker's thread calls it.
//
// A job has a row from its beginning on, without an outcome until it has ended. If the process ends in
// between, the next one completes the row, and no job appears twice. Jobs beyond kMostJobs are removed,
// oldest first; only their usage totals are kept.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "daemon/config/wear_part.hpp"
#include "daemon/history/job_history.hpp"
#include "daemon/system/sqlite.hpp"

namespace contourd {

// Thrown if a later version of contourd made the file, so that this one cannot read it.
class NewerHistory : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// A selection of ended jobs; all conditions must hold.
struct HistoryQuery {
  std::size_t last = 100;                // maximum number of jobs; the latest are returned
  std::optional<std::int64_t> before{};  // jobs before this HistoryPage::before
  std::optional<std::chrono::system_clock::time_point> since{};  // jobs that ended at this time or later
  std::optional<std::string> outcome{}, resin{};
  std::optional<std::string> name{};  // a part of the name
};

struct HistoryPage {
  // Approximate size limit: the page becomes a message, whose formatting may delay light off.
  static constexpr std::size_t kMostBytes = 65'536;

  nlohmann::ordered_json jobs = nlohmann::ordered_json::array();  // from history_json(), the latest last
  std::optional<std::int64_t> before;  // HistoryQuery::before of the next page; nullopt on the last
};

// The usage of all jobs so far, or of all jobs with one resin.
struct Usage {
  std::string resin;
  std::int64_t jobs = 0, layers = 0;  // jobs that were begun, and layers that had light
  double lit_s = 0, resin_ml = 0;
};

class HistoryDatabase {
 public:
  // Maximum number of jobs that are kept.
  static constexpr std::int64_t kMostJobs = 10'000;
  // The reason of a job whose end was not recorded.
  static constexpr const char* kEndNotNoted = "contourd ended before it noted how this job ended";

  // Opens the file or makes it, and checks that it is not damaged. Throws SqliteError, as all functions of
  // this class do, and NewerHistory.
  explicit HistoryDatabase(const std::filesystem::path& file);

  // Adds a job, without an outcome. No two jobs ever have the same `key`.
  void begin(std::int64_t key, const std::string& name, std::chrono::system_clock::time_point when);
  // Stores the usage so far of a job that has not ended.
  void note(std::int64_t key, const JobFigures& figures);
  // Removes a job that was not begun after all.
  void forget(std::int64_t key);
  // Stores the end of a job, and adds the job if begin() was not called for it. A second call changes
  // nothing.
  void end(std::int64_t key, const EndedJob& job);
  // Completes the history when contourd starts: `left` are the jobs that were in printing/, with their
  // outcomes; `last_end` is the last recorded end of a print. Afterwards every job has an outcome.
  void adopt(const std::vector<EndedJob>& left, const std::optional<EndedJob>& last_end);

  [[nodiscard]] HistoryPage list(const HistoryQuery& query);
  // Returns the usage by resin, the resin with most light first; at most a hundred.
  [[nodiscard]] std::vector<Usage> usage_by_resin();
  [[nodiscard]] Usage usage();

  // Notes that the part was replaced: its usage counts from now on.
  void replace(WearPart part, std::chrono::system_clock::time_point when);
  // Returns the usage of all parts, in the order of kWearParts.
  [[nodiscard]] std::vector<WearPartUse> wear();

 private:
  void make_tables();
  void end_left(const EndedJob& job);
  // Returns the key of the job of this name without an outcome; 0 if there is none.
  [[nodiscard]] std::int64_t key_under_way(const std::string& name);
  void forget_oldest();

  SqliteDatabase database_;
};

}  // namespace contourd
