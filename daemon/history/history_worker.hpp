// Runs the history's database on a thread of its own: stores what happens to jobs, and answers queries. The
// event loop never waits for it. One query runs at a time, and users take turns, so that a user with many
// queries delays neither changes nor the queries of others. Event loop's thread only.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "daemon/history/history_database.hpp"
#include "daemon/history/job_history.hpp"
#include "daemon/spool/job_ends.hpp"
#include "daemon/system/control_caller.hpp"
#include "daemon/system/log.hpp"
#include "daemon/system/worker.hpp"

namespace contourd {

class HistoryWorker {
 public:
  // Interval at which a print's usage is stored; a power cut loses at most this much.
  static constexpr Duration kNoteInterval = std::chrono::seconds(30);
  // Maximum number of changes that wait until they can be made. Beyond it the oldest are lost, which is
  // logged once.
  static constexpr std::size_t kMostWaiting = 1'000;

  // Loop, log and record must outlive the object. The worker's thread opens the file.
  HistoryWorker(EventLoop& loop, const Log& log, const std::filesystem::path& file, JobEndRecord& ends);

  // Completes the history when contourd starts, from the ends that wait for it in the record: see
  // HistoryDatabase::adopt().
  void adopt_recorded_ends();
  // Stores that a job begins. Returns its key.
  std::int64_t begin(const std::string& name);
  // Stores the current job's usage if the last time is kNoteInterval ago.
  void note(const std::function<JobFigures()>& figures);
  // Stores the current job's usage. If that is impossible now, records it for the case that this process ends
  // before the print.
  void note_now(const JobFigures& figures);
  // Removes the current job from the history, since it will begin another time.
  void forget();
  // Stores that the current job has ended or was refused, and sets the times and the key in `job`. The end is
  // recorded before the history has it. REQUIRES: begin() was called for the job.
  void end(EndedJob& job);
  // Stores that a job was refused before its turn, and sets the times in `job`. REQUIRES: the job has a key.
  void refuse(EndedJob& job);

  // Receives the answer of a query, later, or nullopt and a sentence that says why; the sentence is empty if
  // the connection that asked is closed.
  template <typename Answer>
  using Done = std::function<void(std::optional<Answer>, const std::string& trouble)>;
  void list(const HistoryQuery& query, const ControlCaller& asker, Done<HistoryPage> done);
  struct AllUsage {
    Usage all;
    std::vector<Usage> by_resin;
    std::vector<WearPartUse> wear;
  };
  void usage(const ControlCaller& asker, Done<AllUsage> done);
  // Queries the usage of the parts, for contourd itself.
  void wear(Done<std::vector<WearPartUse>> done);
  // Stores that the part was replaced. Answers nullopt if that fails; there is no retry.
  void replace(WearPart part, const ControlCaller& asker, Done<AllUsage> done);
  // Drops the queries of this connection.
  void disconnected(std::uint64_t connection);

 private:
  struct UnderWay {
    std::int64_t key = 0;
    std::string name;
    std::chrono::system_clock::time_point began;
    std::optional<TimePoint> noted;
  };
  struct Waiting {
    ControlCaller asker;
    std::function<void(bool gone)> ask;
    bool gone = false;
  };
  // The state of the database after a task.
  struct Health {
    std::string trouble;
    std::vector<std::string> notes;
    bool waits = false;
  };
  using Change = std::function<void(HistoryDatabase&)>;

  void change(Change change);
  template <typename Answer, typename Question>
  void ask(const ControlCaller& asker, Question question, Done<Answer> done);
  void ask_next();
  [[nodiscard]] std::deque<Waiting>::iterator next_question();
  // Logs a change of the database's state, and starts the retry of waiting changes.
  void handle(const Health& health);

  // The worker's thread calls these functions. The first makes the waiting changes and then `change`,
  // and throws std::runtime_error with a sentence; the second drops `change` if it cannot be made now.
  void make_changes(const Change& change);
  [[nodiscard]] Health change_now_or_never(const Change& change);
  [[nodiscard]] Health health();
  void record(const EndedJob& job, JobEnd::Kind kind = JobEnd::Kind::Printed);
  void store_end(HistoryDatabase& database, const EndedJob& job);

  EventLoop& loop_;
  const Log& log_;
  JobEndRecord& ends_;
  std::optional<UnderWay> under_way_;
  std::deque<Waiting> questions_;
  bool asking_ = false;
  uid_t last_asker_ = 0;  // the user of the last query
  bool logged_well_ = true;
  EventLoop::SourcePtr retry_timer_;
  // Used by the worker's thread only:
  HistoryDatabase database_;
  std::deque<Change> waiting_;
  std::vector<std::string> notes_;
  std::string trouble_;  // why changes cannot be written, a sentence; empty if the last one was
  bool loss_noted_ = false;
  Worker worker_;  // the last member: its thread does all tasks before the other members are destroyed
};

}  // namespace contourd
