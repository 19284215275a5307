// The history's file and tables: every job that was begun, and how it ended. Blocks, so a worker's thread
// calls it.
//
// A job has a row from its beginning on, without an outcome until it has ended. If the process ends in
// between, the next one completes the row, and no job appears twice. Jobs beyond kMostJobs are removed,
// oldest first; only their usage totals are kept.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "daemon/config/wear_part.hpp"
#include "daemon/history/job_history.hpp"
#include "daemon/system/sqlite.hpp"

namespace contourd {

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

  // Does not open the file yet.
  explicit HistoryDatabase(std::filesystem::path file) : file_(std::move(file)) {}

  // Opens the file or makes it, and checks that it is not damaged; does nothing if the file is open and was
  // not replaced. Throws std::runtime_error, also as SqliteError and std::system_error.
  void open();
  // Opens the file and calls `call`. If the file is damaged, use() renames it, and calls `call` again with a
  // new file. Throws std::runtime_error with a sentence.
  void use(const std::function<void()>& call);
  // Returns a sentence for each damaged file that was renamed since the last call.
  [[nodiscard]] std::vector<std::string> take_notes() { return std::exchange(notes_, {}); }

  // The functions below REQUIRE an open file, and throw SqliteError.

  // Adds a job, without an outcome. No two jobs ever have the same `key`.
  void begin(std::int64_t key, const std::string& name, std::chrono::system_clock::time_point when);
  // Stores the usage so far of a job that has not ended, unless more is stored already.
  void note(std::int64_t key, const JobFigures& figures);
  // Removes a job that was not begun after all.
  void forget(std::int64_t key);
  // Stores the end of a job, and adds the job if begin() was not called for it. A second call changes
  // nothing.
  void end(std::int64_t key, const EndedJob& job);
  // Completes the history when contourd starts, with the recorded ends that it may lack. Afterwards every job
  // has an outcome. A second call with the same ends changes nothing.
  void adopt(const std::vector<JobEnd>& ends);

  [[nodiscard]] HistoryPage list(const HistoryQuery& query);
  // Returns the usage by resin, the resin with most light first; at most a hundred.
  [[nodiscard]] std::vector<Usage> usage_by_resin();
  [[nodiscard]] Usage usage();

  // Notes that the part was replaced: its usage counts from now on.
  void replace(WearPart part, std::chrono::system_clock::time_point when);
  // Returns the usage of all parts, in the order of kWearParts.
  [[nodiscard]] std::vector<WearPartUse> wear();

 private:
  void put_aside(const std::string& why);
  void check_file();
  void make_tables();
  void adopt_end(const JobEnd& end);
  void forget_oldest();

  std::filesystem::path file_;
  std::optional<SqliteDatabase> database_;
  ino_t inode_ = 0;  // the inode of the open file
  std::vector<std::string> notes_;
};

}  // namespace contourd
