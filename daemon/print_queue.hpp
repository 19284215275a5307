// The jobs in incoming/ that wait for their turn, in the order of their arrival or of their owner. Each is
// read once while it waits, so that its owner hears of a mistake while still there. Event loop's thread only.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/contract/expects.hpp"
#include "daemon/job_reader.hpp"
#include "daemon/job_settings.hpp"
#include "daemon/log.hpp"
#include "daemon/queue_order.hpp"
#include "daemon/spool.hpp"
#include "hw/clock.hpp"

namespace contourd {

struct WaitingJob {
  std::string file;  // in incoming/
  TimePoint arrived;
  enum class Check {
    Wanted,
    Running,
    Passed,
    Postponed,  // there is no room for it in memory beside what is there now
    Refused,    // on its way to failed/, or removed and on its way there
  } check = Check::Wanted;
  std::uint64_t check_number = 0;  // of the one that is running
  // On its way to failed/ it went, by the owner's hand or by the spool's; or was seen to be whole again.
  bool withdrawn = false, seen_again = false;
  std::string postponed{};              // why, already told; empty when it was not
  bool waited = false;                  // for another print, or for the plate
  std::string trouble{};                // why it could not be claimed, already told
  std::optional<JobOutlook> outlook{};  // what its check found; nothing before, and when that found a mistake
};

class PrintQueue {
 public:
  struct Calls {
    // Reads incoming/`file`, and calls `done` from the loop: see JobReader::check(). Of the next job, what
    // was prepared is to be kept.
    std::function<void(const std::string& file, JobReader::Keep keep,
                       std::function<void(const CheckedJob&)> done)>
        check;
    // What was kept of incoming/`file` is not wanted any more.
    std::function<void(const std::string& file)> forget;
    // Files it with its reason, and calls `done` from the loop: see Spool::reject().
    std::function<void(const std::string& file, const std::string& reason, Spool::Rejected done)> reject;
    // Something in the queue may be due now.
    std::function<void()> changed;
    // A job was refused: it is in failed/, or lies where it is for good.
    std::function<void(const std::string& file, const std::string& reason)> refused;
    // The same of one that its owner has removed.
    std::function<void(const std::string& file, const std::string& reason)> removed;
    QueueOrder::Keep keep_order;
  };
  // The log must outlive the queue.
  PrintQueue(const Log& log, Calls calls);

  // So many of the first may be moved, and no job behind them.
  static constexpr std::size_t kMostInOrder = 1'000;

  // The order that the last process has left. Before anything arrives.
  void load_order(std::vector<std::string> files) { order_.load(std::move(files)); }

  // incoming/`file` is whole. Written again, it keeps its place and is checked again.
  void arrived(const std::string& file);
  // incoming/`file` is gone.
  void withdrawn(const std::string& file);

  // Has the first one checked that has not been, if there is one.
  void check_next();
  // Those have their check again for which there was no room: some memory may be free by now.
  void check_postponed();

  [[nodiscard]] bool empty() const { return jobs_.empty(); }
  // The next one first.
  [[nodiscard]] const std::deque<WaitingJob>& jobs() const { return jobs_; }
  // False while the first one's check is being made, or a refused file looks for a name: changed() comes
  // then. REQUIRES: not empty.
  [[nodiscard]] bool first_may_begin() const;

  // It does not begin at once: the time until its first light counts from the end of its wait. REQUIRES: not
  // empty.
  void keep_first_waiting() {
    expects(!empty(), "a job waits");
    jobs_.front().waited = true;
  }
  // It keeps its place until claimed() or put_last(). REQUIRES: not empty.
  [[nodiscard]] WaitingJob take_first();
  // What take_first() gave will not come back.
  void claimed(const std::string& file) { order_.remove(file); }
  // REQUIRES: not empty.
  void refuse_first(const std::string& reason);

  void put_first(WaitingJob job) { jobs_.push_front(std::move(job)); }
  void put_last(WaitingJob job);

  // Its files go to failed/ with this reason, unless somebody is writing them anew. REQUIRES: there is that
  // job, and it is not on its way there.
  void remove(const std::string& file, const std::string& reason);
  // To that place, from 0; the last one when there are fewer. REQUIRES: there is that job; neither its place
  // nor that one is beyond kMostInOrder.
  void move(const std::string& file, std::size_t to);

 private:
  enum class Leaving { Refused, Removed };

  using Position = std::deque<WaitingJob>::iterator;

  [[nodiscard]] Position find(const std::string& file);
  void checked(const std::string& file, std::uint64_t number, const CheckedJob& found);
  void note_check(WaitingJob& job, const CheckedJob& found);
  void postpone(WaitingJob& job, const std::string& why);
  void leave(WaitingJob& job, const std::string& reason, Leaving how);
  struct Reject {
    std::string file, reason;
    Leaving how;
  };
  void rejected(const Reject& job, Spool::Rejection rejection, const std::string& trouble);
  void not_rejected(const Position& job);
  void tell_rejected(const Reject& job, Spool::Rejection rejection, const std::string& trouble) const;
  void remove_withdrawn(const Position& job);

  const Log& log_;
  Calls calls_;
  std::deque<WaitingJob> jobs_;
  QueueOrder order_;
  int rejections_ = 0;  // under way
  std::uint64_t checks_begun_ = 0;
};

// Those of an entry about a file in incoming/.
[[nodiscard]] LogFields file_fields(const std::string& file);
void tell_withdrawn(const Log& log, const std::string& file);

}  // namespace contourd
