// The history as the daemon has it: what happens to jobs goes to its database on a thread of its own, and
// questions about it are answered from there. Nothing waits for it. Whoever asks much makes neither what
// happens to jobs wait nor another user's question: one is asked at a time. Event loop's thread only.
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "daemon/history/history_store.hpp"
#include "daemon/history/job_history.hpp"
#include "daemon/system/control_caller.hpp"
#include "daemon/system/log.hpp"
#include "daemon/system/worker.hpp"

namespace contourd {

class HistoryWorker {
 public:
  // How often what a print has used is noted; a power cut forgets no more.
  static constexpr Duration kNoteInterval = std::chrono::seconds(30);

  // Opens the file on its thread. Loop and log must outlive it.
  HistoryWorker(EventLoop& loop, const Log& log, const std::filesystem::path& file);

  // At the start: see HistoryDatabase::adopt().
  void adopt(std::vector<EndedJob> left, std::optional<EndedJob> last_end);
  // A job's turn has come. Returns its key.
  std::int64_t begin(const std::string& name);
  // What the job under way has used so far: if that was not told for a while.
  void note(const std::function<JobFigures()>& figures);
  // The same, however lately something was told.
  void note_now(const JobFigures& figures);
  // The job under way is to be begun another time.
  void forget();
  // The job under way has ended, or was refused: its times are set. Ready once that is in the database, or
  // cannot be now.
  std::shared_future<void> end(EndedJob& job);
  // A job was refused before its turn: its times are set.
  void refuse(EndedJob& job);

  // Calls `done` later with the answer, or with nothing and a sentence that says why; that is empty where the
  // asker has gone.
  template <typename Answer>
  using Done = std::function<void(std::optional<Answer>, const std::string& trouble)>;
  void list(const HistoryQuery& query, const ControlCaller& asker, Done<HistoryPage> done);
  struct AllUsage {
    Usage all;
    std::vector<Usage> by_resin;
    std::vector<WearPartUse> wear;
  };
  void usage(const ControlCaller& asker, Done<AllUsage> done);
  // Of the parts alone, for contourd itself.
  void wear(Done<std::vector<WearPartUse>> done);
  // The part is new. Nothing when that could not be stored; it is not tried again.
  void replace(WearPart part, const ControlCaller& asker, Done<AllUsage> done);
  // What that connection asked is looked up no more.
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
  // Of the store, behind a task.
  struct Health {
    std::string trouble;
    std::vector<std::string> notes;
    bool waits = false;
  };

  std::shared_future<void> change(HistoryStore::Call call);
  std::shared_future<void> change_for(std::int64_t key, EndedJob& job);
  template <typename Answer, typename Question>
  void ask(const ControlCaller& asker, Question question, Done<Answer> done);
  void ask_next();
  [[nodiscard]] std::deque<Waiting>::iterator next_question();
  [[nodiscard]] static Health health_of(HistoryStore& store);
  void tell(const Health& health);

  EventLoop& loop_;
  const Log& log_;
  std::shared_ptr<HistoryStore> store_;  // the worker's
  std::optional<UnderWay> under_way_;
  std::deque<Waiting> questions_;
  bool asking_ = false;
  uid_t last_asker_ = 0;  // a user
  bool told_well_ = true;
  EventLoop::SourcePtr retry_timer_;
  Worker worker_;  // last: its thread ends before what its tasks use, and does them all before
};

}  // namespace contourd
