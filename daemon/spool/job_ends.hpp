// The durable record of the jobs that have ended. A job's end stays in the record until its files are in
// done/ or failed/, the history has the end, and the notice of it was sent. After a kill or a power cut, the
// next process completes what is missing. The record is in the state folder (state_records.hpp).
// Thread-safe. Functions block until the disk has the record, so the event loop's thread must not call them
// once the loop runs.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/spool/state_records.hpp"

namespace contourd {

// The end of a job. A value.
struct JobEnd {
  std::int64_t key = 0;  // identifies the end here and in the history: see new_job_key()
  std::string job;       // name in printing/, done/ or failed/
  std::string outcome;   // "done", "cancelled" or "failed"
  std::string reason{};  // the record keeps its first 1000 bytes
  std::chrono::system_clock::time_point ended{};
  enum class Kind : std::uint8_t {
    Printed,      // its print began
    Refused,      // refused or removed before its print began
    Interrupted,  // no process recorded its end: the power was cut, or contourd was killed or crashed
  } kind = Kind::Printed;
  // The name in incoming/, the mark_of() and the change_time() of a job that was refused there; empty if the
  // job was in printing/.
  std::string file{}, mark{};
  std::int64_t changed_ns = 0;
  // The figures of a print as the history writes them (job_history.hpp); empty if it has none.
  std::string figures{};
};

// Returns a random key that is not 0.
[[nodiscard]] std::int64_t new_job_key();

// Returns the end of a print that no process has recorded.
[[nodiscard]] JobEnd interruption(std::int64_t key, const std::string& job);
// The reason of an interruption.
inline constexpr std::string_view kWhyInterrupted = "the power was cut, or contourd was killed or crashed";

// The parts of contourd that need to know a job's end.
enum class EndConsumer : std::uint8_t { Files, History, Notice };

class JobEndRecord {
 public:
  // Maximum number of ends that are kept; beyond it the oldest is dropped.
  static constexpr std::size_t kMost = 200;

  // An end, and the consumers that it waits for.
  struct Pending {
    JobEnd end;
    std::vector<EndConsumer> consumers;

    [[nodiscard]] bool awaits(EndConsumer consumer) const;
  };

  // Reads the record of the last process; ignores what is no valid end. The records must outlive this object.
  explicit JobEndRecord(const StateRecords& records);

  // Adds an end that waits for all consumers. If its key is there already, only an interruption is replaced,
  // which may be recorded while the print goes on. Throws std::system_error if the disk does not accept it;
  // then only this process knows of it, and the next write tries again.
  void add(const JobEnd& end);
  // Notes that a consumer has the end. Removes an end that all consumers have; if the disk does not accept
  // that, the next process gives the end to the consumers once more.
  void taken(std::int64_t key, EndConsumer consumer);
  // Notes that the files of the job in printing/ are in done/ or failed/, or that someone removed them.
  void files_taken(std::string_view job);
  // Removes an end: the job is not over.
  void drop(std::int64_t key);
  // Notes on the disk that no end is about files of this name in printing/, because another job gets the
  // name. Throws std::system_error.
  void release_name(std::string_view job);

  // Returns the end of the job in printing/ with this name; nullopt if there is none.
  [[nodiscard]] std::optional<JobEnd> end_of(std::string_view job) const;
  // Returns all ends, the oldest first.
  [[nodiscard]] std::vector<Pending> pending() const;

 private:
  using Position = std::vector<Pending>::iterator;

  void take(Position end, EndConsumer consumer);
  void save();
  void note_saved();
  void save_if_possible();

  const StateRecords& records_;
  mutable std::mutex mutex_;
  std::vector<Pending> ends_;
  std::set<std::string, std::less<>> unfiled_on_disk_;  // names that wait for their files in the saved record
  bool saved_ = true;
};

}  // namespace contourd
