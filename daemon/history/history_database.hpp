// The history's tables: every job that was begun, and how it ended. Blocks: for a worker's thread.
//
// A job has a row from its beginning on, without an outcome until it has ended. So a process that ends in
// between leaves the row for the next one to complete, and no job is there twice. Of the oldest jobs, beyond
// a number, only what they used is kept.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "daemon/config/wear_part.hpp"
#include "daemon/history/job_history.hpp"
#include "daemon/system/sqlite.hpp"

namespace contourd {

// A later contourd made the file, and it says what an earlier one cannot know.
class NewerHistory : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Which of the ended jobs are wanted.
struct HistoryQuery {
  std::size_t last = 100;                                        // so many at most, the latest
  std::optional<std::int64_t> before{};                          // earlier ones than this, as a page told it
  std::optional<std::chrono::system_clock::time_point> since{};  // ended then or later
  std::optional<std::string> outcome{}, resin{};
  std::optional<std::string> name{};  // a part of it
};

struct HistoryPage {
  // About: it becomes a message while a light may wait.
  static constexpr std::size_t kMostBytes = 65'536;

  nlohmann::ordered_json jobs = nlohmann::ordered_json::array();  // as history_json(), the latest last
  std::optional<std::int64_t> before;  // there are earlier ones: what to ask for them with
};

// What was used up so far, by jobs of this resin or by all.
struct Usage {
  std::string resin;
  std::int64_t jobs = 0, layers = 0;  // that were begun; that had light
  double lit_s = 0, resin_ml = 0;
};

class HistoryDatabase {
 public:
  // Of more only what they used is kept.
  static constexpr std::int64_t kMostJobs = 10'000;
  // What a job that was under way says when nobody noted how it ended.
  static constexpr const char* kEndNotNoted = "contourd ended before it noted how this job ended";

  // Opens the file or makes it; looks whether it is sound, and brings it up to date. Throws SqliteError, as
  // all else here, and NewerHistory.
  explicit HistoryDatabase(const std::filesystem::path& file);

  // `key` tells jobs apart, for ever.
  void begin(std::int64_t key, const std::string& name, std::chrono::system_clock::time_point when);
  // What a job under way has used so far.
  void note(std::int64_t key, const JobFigures& figures);
  // It was not begun after all.
  void forget(std::int64_t key);
  // Also of one that was not begun here. Once more changes nothing.
  void end(std::int64_t key, const EndedJob& job);
  // At a start: `left` lay in printing/, and ended so. `last_end` is how the last print that was recorded
  // ended, if that is known, its name printable. No job is under way afterwards.
  void adopt(const std::vector<EndedJob>& left, const std::optional<EndedJob>& last_end);

  [[nodiscard]] HistoryPage list(const HistoryQuery& query);
  // By resin, the one with most light first; a hundred at most.
  [[nodiscard]] std::vector<Usage> usage_by_resin();
  [[nodiscard]] Usage usage();

  // The part is new: its use counts from here on.
  void replace(WearPart part, std::chrono::system_clock::time_point when);
  // Of all parts, in their order.
  [[nodiscard]] std::vector<WearPartUse> wear();

 private:
  void migrate();
  // Id and name of all without an outcome.
  [[nodiscard]] std::vector<std::pair<std::int64_t, std::string>> under_way();
  void end_left(const EndedJob& job);
  // Of the one of this name without an outcome; 0 where there is none.
  [[nodiscard]] std::int64_t key_under_way(const std::string& name);
  void forget_oldest();

  SqliteDatabase database_;
};

}  // namespace contourd
