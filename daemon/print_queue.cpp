#include "daemon/print_queue.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "core/contract/expects.hpp"
#include "daemon/readable.hpp"

namespace contourd {

PrintQueue::Position PrintQueue::find(const std::string& file) {
  return std::ranges::find(jobs_, file, &WaitingJob::file);
}

void PrintQueue::arrived(const std::string& file) {
  const Position queued = find(file);
  if (queued != jobs_.end() && queued->check == WaitingJob::Check::Refused) {
    // What lies there goes to failed/, unless it was written anew: rejected() knows.
    queued->withdrawn = false;
    queued->seen_again = true;
    return;
  }
  WaitingJob job{.file = file, .arrived = std::chrono::steady_clock::now()};
  if (queued != jobs_.end()) {
    job.trouble = std::move(queued->trouble);  // told already
    *queued = std::move(job);
    calls_.forget(file);
  } else {
    jobs_.push_back(std::move(job));
    log_.info("queued", fmt::format("{}: arrived, number {} in the queue", printable(file), jobs_.size()),
              file_fields(file));
  }
  calls_.changed();
}

void PrintQueue::withdrawn(const std::string& file) {
  const Position job = find(file);
  if (job == jobs_.end()) return;
  if (job->check == WaitingJob::Check::Refused) {
    // Most likely the spool took it: rejected() knows.
    job->withdrawn = true;
    return;
  }
  remove_withdrawn(job);
}

void PrintQueue::remove_withdrawn(const Position& job) {
  const std::string file = job->file;
  jobs_.erase(job);
  calls_.forget(file);
  tell_withdrawn(log_, file);
  calls_.changed();
}

void PrintQueue::check_next() {
  const Position wanted = std::ranges::find(jobs_, WaitingJob::Check::Wanted, &WaitingJob::check);
  if (wanted == jobs_.end()) return;
  wanted->check = WaitingJob::Check::Running;
  const std::uint64_t number = wanted->check_number = ++checks_begun_;
  const auto keep = wanted == jobs_.begin() ? JobReader::Keep::Prepared : JobReader::Keep::Nothing;
  calls_.check(wanted->file, keep,
               [this, file = wanted->file, number](const std::optional<JobRefusal>& refusal) {
                 checked(file, number, refusal);
               });
}

void PrintQueue::checked(const std::string& file, std::uint64_t number,
                         const std::optional<JobRefusal>& refusal) {
  const Position job = find(file);
  // Gone, or written again meanwhile: what was found out is about another file.
  if (job != jobs_.end() && job->check == WaitingJob::Check::Running && job->check_number == number) {
    if (refusal && refusal->for_now) {
      postpone(*job, refusal->reason);
    } else if (refusal && refusal->profile.empty()) {
      return refuse(*job, refusal->reason);
    } else {
      job->check = WaitingJob::Check::Passed;
      job->postponed.clear();
      // When its turn comes, the profile is read again.
      if (refusal)
        log_.warning("profile", fmt::format("{}: {}", printable(file), printable(refusal->profile)),
                     file_fields(file));
    }
  }
  calls_.changed();
}

void PrintQueue::postpone(WaitingJob& job, const std::string& why) {
  job.check = WaitingJob::Check::Postponed;
  // Its figures change all the time.
  if (!std::exchange(job.postponed, why).empty()) return;
  log_.info(
      "postponed",
      fmt::format("{}: is read later, because there is not enough memory now: {}", printable(job.file), why),
      file_fields(job.file));
}

void PrintQueue::check_postponed() {
  for (WaitingJob& job : jobs_) {
    if (job.check == WaitingJob::Check::Postponed) job.check = WaitingJob::Check::Wanted;
  }
}

bool PrintQueue::first_may_begin() const {
  expects(!empty(), "a job waits");
  return jobs_.front().check != WaitingJob::Check::Running && rejections_ == 0;
}

WaitingJob PrintQueue::take_first() {
  expects(!empty(), "a job waits");
  WaitingJob job = std::move(jobs_.front());
  jobs_.pop_front();
  return job;
}

void PrintQueue::put_last(WaitingJob job) {
  calls_.forget(job.file);
  jobs_.push_back(std::move(job));
}

void PrintQueue::refuse_first(const std::string& reason) {
  expects(!empty(), "a job waits");
  refuse(jobs_.front(), reason);
}

void PrintQueue::refuse(WaitingJob& job, const std::string& reason) {
  job.check = WaitingJob::Check::Refused;
  ++rejections_;
  calls_.reject(job.file, reason + "\n",
                [this, file = job.file, reason](Spool::Rejection rejection, const std::string& trouble) {
                  rejected(file, reason, rejection, trouble);
                });
}

void PrintQueue::rejected(const std::string& file, const std::string& reason, Spool::Rejection rejection,
                          const std::string& trouble) {
  --rejections_;
  const Position job = std::ranges::find_if(jobs_, [&](const WaitingJob& each) {
    return each.file == file && each.check == WaitingJob::Check::Refused;
  });
  if (rejection == Spool::Rejection::Unfinished) return not_rejected(job);
  if (job != jobs_.end()) jobs_.erase(job);
  tell_refused(file, reason, rejection, trouble);
  calls_.refused(file, reason);
  calls_.changed();
}

// It is checked again when it is whole.
void PrintQueue::not_rejected(const Position& job) {
  if (job != jobs_.end()) {
    if (job->withdrawn) return remove_withdrawn(job);
    job->check = job->seen_again ? WaitingJob::Check::Wanted : WaitingJob::Check::Passed;
    job->seen_again = false;
  }
  calls_.changed();
}

void PrintQueue::tell_refused(const std::string& file, const std::string& reason, Spool::Rejection rejection,
                              const std::string& trouble) const {
  log_.error("refused", fmt::format("{}: {}", printable(file), reason), file_fields(file));
  if (rejection == Spool::Rejection::LeftThere)
    log_.warning(
        "refused",
        fmt::format("{}: stays in incoming, because it cannot be moved; it may be deleted", printable(file)),
        file_fields(file));
  if (rejection == Spool::Rejection::Impossible)
    log_.error("refused",
               fmt::format("{}: cannot be moved to failed: {}", printable(file), printable(trouble)));
}

LogFields file_fields(const std::string& file) {
  return job_fields(job_name_of(file));
}

void tell_withdrawn(const Log& log, const std::string& file) {
  log.info("withdrawn", fmt::format("{}: taken away by the owner", printable(file)), file_fields(file));
}

}  // namespace contourd
