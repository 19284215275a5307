// The printer service's readings of jobs: the one whose turn it is, and those that wait, one at a time.
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "daemon/job_memory.hpp"
#include "daemon/printer_service.hpp"
#include "daemon/readable.hpp"

namespace contourd {
namespace {

using namespace std::chrono_literals;

// What is told of why a job is refused goes into the log, a file and each answer to a client.
constexpr std::size_t kLongestReason = 8000;
// The memory of a print goes back to the system some moments behind its end: how often a job whose turn it is
// looks for room, and how long it waits in between.
constexpr int kMostReadings = 5;
constexpr Duration kReadingInterval = 1s;

std::string told(const JobRefused& refusal) {
  return printable_lines(shortened(refusal.what(), kLongestReason));
}

}  // namespace

std::variant<PreparedJob, PrinterService::Refusal> PrinterService::read(
    const JobFiles& files, const std::optional<JobSettings>& settings) {
  if (reading_record_.take_ended(files)) return Refusal{std::string(kEndedAProcess)};
  const ReadingRecord::Reading under_way(reading_record_, files);
  try {
    // Without settings, the ticket is read to hear what is wrong with it.
    return prepare_job(files, settings ? *settings : read_settings(files, config_), config_);
  } catch (const JobTooLarge& refusal) {
    return Refusal{told(refusal), refusal.fits_alone()};
  } catch (const ProfileTrouble& trouble) {
    const bool of_profile = trouble.fault() == ProfileTrouble::Fault::Profile;
    return Refusal{told(trouble), false, of_profile ? trouble.sentence() : ""};
  } catch (const JobRefused& refusal) {
    return Refusal{told(refusal)};
  }
}

void PrinterService::read_active() {
  worker_.run([files = active_->files, settings = active_->settings, this] { return read(files, settings); },
              [this](std::variant<PreparedJob, Refusal> result) { prepared(std::move(result)); });
}

bool PrinterService::read_later(const Refusal& refusal) {
  if (!refusal.for_now || active_->cancel_wanted || shutting_down_) return false;
  if (++active_->readings >= kMostReadings) return false;
  read_timer_ = loop_.at(std::chrono::steady_clock::now() + kReadingInterval, "a job's timer", [this] {
    if (active_) read_active();
  });
  return true;
}

// A waiting job is read once when it arrives, so that its owner hears of a mistake while still there.
void PrinterService::check_waiting() {
  const auto wanted = std::find_if(queue_.begin(), queue_.end(), [](const QueuedJob& job) {
    return job.check == QueuedJob::Check::Wanted;
  });
  if (wanted == queue_.end()) return;
  wanted->check = QueuedJob::Check::Running;
  const std::string file = wanted->file;
  worker_.run(
      [file, this]() -> std::optional<Refusal> {
        auto result = read(spool_.files_of(Spool::Folder::Incoming, file), std::nullopt);
        if (auto* refusal = std::get_if<Refusal>(&result)) return std::move(*refusal);
        return std::nullopt;
      },
      [this, file](const std::optional<Refusal>& refusal) { checked(file, refusal); });
}

void PrinterService::checked(const std::string& file, const std::optional<Refusal>& refusal) {
  const auto job =
      std::find_if(queue_.begin(), queue_.end(), [&](const QueuedJob& q) { return q.file == file; });
  // Gone, or written again meanwhile: what was found out is about another file.
  if (job != queue_.end() && job->check == QueuedJob::Check::Running) {
    if (refusal && refusal->for_now) {
      postpone(*job, refusal->reason);
    } else if (refusal && refusal->profile.empty()) {
      return reject(*job, refusal->reason);
    } else {
      job->check = QueuedJob::Check::Passed;
      job->postponed.clear();
      // When its turn comes, the profile is read again.
      if (refusal)
        log_.warning("profile", fmt::format("{}: {}", printable(file), printable(refusal->profile)),
                     {{"JOB_ID", printable(job_name_of(file))}});
    }
  }
  pump();
}

void PrinterService::postpone(QueuedJob& job, const std::string& why) {
  job.check = QueuedJob::Check::Postponed;
  // Its figures change all the time.
  if (!std::exchange(job.postponed, why).empty()) return;
  log_.info("postponed",
            fmt::format("{}: is read later, as there is no room in memory now: {}", printable(job.file), why),
            {{"JOB_ID", printable(job_name_of(job.file))}});
}

void PrinterService::check_postponed() {
  for (QueuedJob& job : queue_) {
    if (job.check == QueuedJob::Check::Postponed) job.check = QueuedJob::Check::Wanted;
  }
}

}  // namespace contourd
